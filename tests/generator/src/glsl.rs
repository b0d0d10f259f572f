//! Faults of a shader, or of what shaders include.

use tree_sitter::{Node, Parser};

use crate::Fault;

/// Every fault of a source, in order. Macros, layouts and sizes of arrays are left out: they are an interface, or no program
/// without them.
pub fn faults(source: &str) -> Vec<Fault> {
    let mut parser = Parser::new();
    parser.set_language(&tree_sitter_glsl::LANGUAGE_GLSL.into()).expect("the grammar");
    let tree = parser.parse(source, None).expect("no limit of time");
    let mut finder = Finder { source, faults: Vec::new() };
    finder.visit(tree.root_node());
    finder.faults
}

struct Finder<'a> {
    source: &'a str,
    faults: Vec<Fault>,
}

impl Finder<'_> {
    fn text(&self, node: Node) -> &str {
        &self.source[node.byte_range()]
    }

    /// The text of a part that the grammar names.
    fn part(&self, node: Node, name: &str) -> &str {
        node.child_by_field_name(name).map_or("", |part| self.text(part))
    }

    fn add(&mut self, of: Node, put: impl Into<String>) {
        let line = of.start_position().row + 1;
        self.faults.push(Fault { place: of.byte_range(), put: put.into(), line });
    }

    fn visit(&mut self, node: Node) {
        match node.kind() {
            "preproc_def"
            | "preproc_function_def"
            | "preproc_include"
            | "preproc_call"
            | "layout_specification" => return,
            "array_declarator" => {
                return node
                    .child_by_field_name("declarator")
                    .into_iter()
                    .for_each(|of| self.visit(of));
            }
            "binary_expression" => self.binary(node),
            "assignment_expression" => self.assignment(node),
            "unary_expression" if ["-", "!"].contains(&self.part(node, "operator")) => {
                self.add(node, format!("({})", self.part(node, "argument")));
            }
            "call_expression" => self.call(node),
            "number_literal" => self.number(node),
            "field_expression" => self.swizzle(node),
            "subscript_expression" => {
                if let Some(index) = node.child_by_field_name("index") {
                    self.add(index, format!("({}) + 1", self.text(index)));
                }
            }
            "if_statement" | "conditional_expression" => {
                if let Some(condition) = node.child_by_field_name("condition") {
                    self.add(condition, "(true)");
                    self.add(condition, "(false)");
                }
            }
            _ => {}
        }
        for child in node.children(&mut node.walk()) {
            self.visit(child);
        }
    }

    fn binary(&mut self, node: Node) {
        let (left, right) = (self.part(node, "left").to_string(), self.part(node, "right"));
        let others: &[&str] = match self.part(node, "operator") {
            "+" => &["-"],
            "-" => &["+"],
            "*" => &["/"],
            "/" => &["*"],
            "&&" => &["||"],
            "||" => &["&&"],
            "<" => &["<=", ">"],
            "<=" => &["<", ">"],
            ">" => &[">=", "<"],
            ">=" => &[">", "<"],
            "==" => &["!="],
            "!=" => &["=="],
            _ => return,
        };
        let mut put: Vec<String> =
            others.iter().map(|other| format!("(({left}) {other} ({right}))")).collect();
        if ["+", "-", "*", "/"].contains(&self.part(node, "operator")) {
            // One term is forgotten.
            put.push(format!("({left})"));
        }
        put.into_iter().for_each(|put| self.add(node, put));
    }

    fn assignment(&mut self, node: Node) {
        let others: &[&str] = match self.part(node, "operator") {
            "+=" => &["-=", "="],
            "-=" => &["+="],
            "*=" => &["/=", "="],
            "/=" => &["*="],
            _ => return,
        };
        let operator = node.child_by_field_name("operator").expect("it was matched");
        others.iter().for_each(|other| self.add(operator, *other));
    }

    fn call(&mut self, node: Node) {
        let Some(function) = node.child_by_field_name("function") else { return };
        let other = match self.text(function) {
            "min" => "max",
            "max" => "min",
            "floor" => "ceil",
            "ceil" => "floor",
            "any" => "all",
            "all" => "any",
            "sin" => "cos",
            "cos" => "sin",
            "abs" | "sqrt" | "clamp" | "normalize" | "fract" | "mix" => {
                let arguments = node.child_by_field_name("arguments").expect("of a call");
                let first = arguments.named_child(0).expect("each has one");
                return self.add(node, format!("({})", self.text(first)));
            }
            _ => return,
        };
        self.add(function, other);
    }

    fn number(&mut self, node: Node) {
        let text = self.text(node).to_string();
        if text.contains('.') || text.contains('e') && !text.starts_with("0x") {
            self.add(node, format!("({text} * 0.9)"));
            self.add(node, format!("({text} * 1.1)"));
        } else {
            let sign = if text.trim_end_matches('u') == "0" { '+' } else { '-' };
            self.add(node, format!("({text} {sign} 1)"));
        }
    }

    fn swizzle(&mut self, node: Node) {
        const ORDER: [char; 4] = ['x', 'y', 'z', 'w'];
        let Some(field) = node.child_by_field_name("field") else { return };
        let text = self.text(field);
        if !text.chars().all(|letter| ORDER.contains(&letter)) {
            return;
        }
        let other: String = match text {
            "x" => "y".into(),
            "y" => "x".into(),
            "z" => "y".into(),
            "w" => "z".into(),
            _ => text.chars().rev().collect(),
        };
        if other != text {
            self.add(field, other);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::faults;

    #[test]
    fn faults_are_where_a_hand_slips() {
        let source = "#include \"a.glsl\"\n#define N 3\nlayout(set = 0, binding = 1) buffer B { uint b[7]; };\n\
                      float f(vec3 v, uint i) {\n#ifdef TEXELS\n    if (i < 2u && v.x > 0.5) return -max(v.y, 1e-3);\n#endif\n\
                      v.xy += 4.0 * v.zy;\n    return i == 3u ? sqrt(v.z) : float(b[i]);\n}\n";
        let found = faults(source);
        let put: Vec<&str> = found.iter().map(|fault| fault.put.as_str()).collect();
        let expected = [
            "((i) <= (2u))",
            "((i < 2u) || (v.x > 0.5))",
            "(0.5 * 1.1)",
            "(max(v.y, 1e-3))",
            "min",
            "(1e-3 * 0.9)",
            "-=",
            "yz",
            "(v.z)",
            "(i) + 1",
            "(false)",
            "(2u - 1)",
            "(4.0)",
        ];
        for expected in expected {
            assert!(put.contains(&expected), "{expected} is not in {put:#?}");
        }
        let of_interface = found.iter().filter(|fault| fault.line <= 3).map(|fault| &fault.put);
        assert_eq!(of_interface.collect::<Vec<_>>(), Vec::<&String>::new());
    }
}
