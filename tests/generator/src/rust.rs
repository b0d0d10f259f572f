//! Faults of a Rust source.

use proc_macro2::Span;
use syn::spanned::Spanned as _;
use syn::visit::{self, Visit};
use syn::{BinOp, Expr, Lit, UnOp};

use crate::Fault;

/// Every fault of a source, in order. Those in constants, types, patterns and tests are left out: no number can choose
/// them while the program runs, or they are no program.
pub fn faults(source: &str) -> Vec<Fault> {
    let file = syn::parse_file(source).expect("a Rust source");
    let mut found = Finder { source, faults: Vec::new() };
    found.visit_file(&file);
    found.faults
}

struct Finder<'a> {
    source: &'a str,
    faults: Vec<Fault>,
}

impl Finder<'_> {
    fn text(&self, span: Span) -> &str {
        &self.source[span.byte_range()]
    }

    fn add(&mut self, of: &Expr, put: String) {
        let span = of.span();
        self.faults.push(Fault { place: span.byte_range(), put, line: span.start().line });
    }

    fn binary(&mut self, whole: &Expr, expression: &syn::ExprBinary) {
        let others: &[&str] = match expression.op {
            BinOp::Add(_) => &["-"],
            BinOp::Sub(_) => &["+"],
            BinOp::Mul(_) => &["/"],
            BinOp::Div(_) | BinOp::Rem(_) => &["*"],
            BinOp::And(_) => &["||"],
            BinOp::Or(_) => &["&&"],
            BinOp::Lt(_) => &["<=", ">"],
            BinOp::Le(_) => &["<", ">"],
            BinOp::Gt(_) => &[">=", "<"],
            BinOp::Ge(_) => &[">", "<"],
            BinOp::Eq(_) => &["!="],
            BinOp::Ne(_) => &["=="],
            _ => return,
        };
        let left = self.text(expression.left.span()).to_string();
        let right = self.text(expression.right.span()).to_string();
        for other in others {
            self.add(whole, format!("({left}) {other} ({right})"));
        }
        if matches!(expression.op, BinOp::Add(_) | BinOp::Sub(_) | BinOp::Mul(_) | BinOp::Div(_)) {
            // One term is forgotten.
            self.add(whole, format!("({left})"));
        }
    }

    fn method(&mut self, whole: &Expr, call: &syn::ExprMethodCall) {
        let other = match &*call.method.to_string() {
            "min" => "max",
            "max" => "min",
            "any" => "all",
            "all" => "any",
            "is_some" => "is_none",
            "is_none" => "is_some",
            "first" => "last",
            "last" => "first",
            "floor" => "ceil",
            "ceil" => "floor",
            "is_some_and" => "is_none_or",
            "is_none_or" => "is_some_and",
            "abs" | "rev" | "clamp" | "sqrt" | "trim" => {
                let receiver = self.text(call.receiver.span()).to_string();
                return self.add(whole, format!("({receiver})"));
            }
            _ => return,
        };
        let (name, all) = (call.method.span().byte_range(), whole.span().byte_range());
        let put = [&self.source[all.start..name.start], other, &self.source[name.end..all.end]];
        self.add(whole, put.concat());
    }

    fn literal(&mut self, whole: &Expr, literal: &Lit) {
        let text = self.text(whole.span()).to_string();
        match literal {
            Lit::Float(_) => self.add(whole, format!("({text} * 1.1)")),
            Lit::Int(number) if number.base10_digits() == "0" => self.add(whole, "1".into()),
            Lit::Int(_) => self.add(whole, format!("({text} - 1)")),
            Lit::Bool(value) => self.add(whole, (!value.value).to_string()),
            _ => {}
        }
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_expr(&mut self, expression: &'ast Expr) {
        match expression {
            Expr::Binary(binary) => self.binary(expression, binary),
            Expr::MethodCall(call) => self.method(expression, call),
            Expr::Lit(literal) => self.literal(expression, &literal.lit),
            Expr::Unary(unary) if matches!(unary.op, UnOp::Neg(_) | UnOp::Not(_)) => {
                self.add(expression, format!("({})", self.text(unary.expr.span())));
            }
            _ => {}
        }
        visit::visit_expr(self, expression);
    }

    fn visit_expr_if(&mut self, expression: &'ast syn::ExprIf) {
        if !matches!(*expression.cond, Expr::Let(_)) {
            for always in ["true", "false"] {
                self.add(&expression.cond, always.into());
            }
        }
        visit::visit_expr_if(self, expression);
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if item.sig.constness.is_none() {
            visit::visit_item_fn(self, item);
        }
    }

    fn visit_impl_item_fn(&mut self, item: &'ast syn::ImplItemFn) {
        if item.sig.constness.is_none() {
            visit::visit_impl_item_fn(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        let is_test = |attribute: &syn::Attribute| self.text(attribute.span()).contains("test");
        if !item.attrs.iter().any(is_test) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_const(&mut self, _: &'ast syn::ItemConst) {}
    fn visit_impl_item_const(&mut self, _: &'ast syn::ImplItemConst) {}
    fn visit_item_static(&mut self, _: &'ast syn::ItemStatic) {}
    fn visit_attribute(&mut self, _: &'ast syn::Attribute) {}
    fn visit_type(&mut self, _: &'ast syn::Type) {}
    fn visit_pat(&mut self, _: &'ast syn::Pat) {}
    fn visit_expr_const(&mut self, _: &'ast syn::ExprConst) {}

    fn visit_expr_repeat(&mut self, expression: &'ast syn::ExprRepeat) {
        // The length is a constant.
        self.visit_expr(&expression.expr);
    }

    fn visit_generic_argument(&mut self, _: &'ast syn::GenericArgument) {}
}

#[cfg(test)]
mod tests {
    use super::faults;

    #[test]
    fn faults_are_where_a_hand_slips() {
        let source = "fn f(a: f64, b: &[u8]) -> bool { let n = [0; 4]; if a < 2.0 * b.len() as f64 { return b.is_empty() } n[0] == 0 }\n\
                      const C: f64 = 1.0;\n#[cfg(test)]\nmod tests { fn g() -> bool { 1 < 2 } }";
        let put: Vec<String> = faults(source).into_iter().map(|fault| fault.put).collect();
        for expected in
            ["true", "(a) <= (2.0 * b.len() as f64)", "(2.0 * 1.1)", "(n[0]) != (0)", "(2.0)"]
        {
            assert!(put.iter().any(|put| put == expected), "{expected} is not in {put:#?}");
        }
        assert!(!put.iter().any(|put| put.contains("(1) ") || put == "(4 - 1)"), "{put:#?}");
    }
}
