//! A key of a scene is written once: `new_key.patch` adds one to a file of `src/scene`, and it is everywhere.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::mutants::{copy_sources, root};

fn told(command: &mut Command) -> String {
    let output = command.output().expect("it starts");
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{command:?}: {said}");
    String::from_utf8(output.stdout).expect("UTF-8")
}

#[test]
#[ignore = "builds the program again: minutes"]
fn a_key_is_added_in_one_file() {
    let tree = root().join("target/new-key/tree");
    fs::create_dir_all(&tree).expect("a folder");
    copy_sources(&tree, &[]);
    let patch = root().join("tests/house/new_key.patch");
    let text = fs::read_to_string(&patch).expect("the patch");
    let files = text.lines().filter(|line| line.starts_with("+++ ")).collect::<Vec<_>>();
    assert!(files.len() == 1 && files[0].starts_with("+++ b/src/scene/"), "{files:?}");
    // No repository is looked for above, whose files these are not.
    let mut apply = Command::new("git");
    apply.args(["apply", "--recount"]).arg(&patch).current_dir(&tree);
    told(apply.env("GIT_CEILING_DIRECTORIES", tree.parent().expect("a folder")));

    let build = root().join("target/new-key/build");
    let cargo = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO"));
        command.args(arguments).current_dir(&tree).env("CARGO_TARGET_DIR", &build);
        command
    };
    told(&mut cargo(&["build", "--bin", "raindrops"]));
    let program = build.join("debug/raindrops");
    let run = |arguments: &[&str]| told(Command::new(&program).args(arguments).current_dir(&tree));

    let plan = run(&["plan", "--set", "model.dummy=3"]);
    assert!(plan.lines().any(|line| line.split_whitespace().eq(["dummy", "3"])), "{plan}");
    let refused = Command::new(&program).args(["plan", "--set", "model.dummy=10"]).output();
    let said = String::from_utf8_lossy(&refused.expect("it starts").stderr).into_owned();
    assert!(said.contains("model: dummy = 10 is not within 1 to 9"), "{said}");
    assert!(run(&["schema"]).contains("A key that nothing reads."));
    let result = tree.join("bench.json");
    let file = result.to_str().expect("UTF-8");
    run(&["bench", "--drops", "100", "--size", "16x16", "--set", "model.dummy=3", "--json", file]);
    let result: serde_json::Value =
        serde_json::from_str(&fs::read_to_string(&result).expect("results")).expect("JSON");
    assert_eq!(result["rows"][0]["axes"]["dummy"], 3, "{result:#}");

    let mut docs = cargo(&["test", "--test", "house", "tables_of_keys"]);
    told(docs.env("RAINDROPS_WRITE_KEYS", "1"));
    let page = fs::read_to_string(tree.join(Path::new("docs/scene.md"))).expect("the page");
    assert!(page.contains("| `model.dummy` |  | 1 to 9 | A key that nothing reads. |"));
}
