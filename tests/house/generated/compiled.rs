//! Faults in shaders: each is compiled by itself and handed to the tests. One that no test notices has survived if it changes a
//! picture of random scenes; else nobody can tell it, and it is set aside.

use std::collections::BTreeSet;
use std::fs;
use std::process::Command;

use super::{List, Part, Results, Tests, shuffled};
use crate::replaced::{Compiled, compile};

/// The program and its test that print what tells pictures of random scenes apart.
pub const PICTURES: (&str, &str) = ("hunt", "pictures::digests_of_random_scenes");

/// A fault that is no program, or that changes no shader: another is taken.
const NONE: &str = "changes no shader";
/// A fault that no test notices and no picture shows.
const UNSEEN: &str = "changes no picture";

/// What became of as many faults of a part as it is to have, and which they are.
pub fn outcomes(
    list: &List,
    part: &Part,
    count: usize,
    tests: &mut Tests,
    results: &mut Results,
) -> Vec<(String, String)> {
    let folder = tests.tree.with_file_name("glsl");
    let (mut found, mut unseen, mut own) = (Vec::new(), 0, None);
    for one in shuffled(list, part) {
        if found.len() == count {
            break;
        }
        let key = one.key();
        let outcome = results.outcome(&key, || {
            let (place, put) = (one.fault.place.clone(), &one.fault.put);
            let Compiled { changed, broken } = compile(&tests.tree, &folder, &one.file, place, put);
            if broken > 0 || changed == 0 {
                return NONE.into();
            }
            let shaders = folder.to_str().expect("a path in UTF-8");
            let variable = ("RAINDROPS_TEST_GLSL", shaders);
            if let Some(test) = tests.that_notices(&part.tests, variable) {
                return format!("noticed by {test}");
            }
            let own = own.get_or_insert_with(|| pictures(tests, None));
            let same = pictures(tests, Some(variable)) == *own;
            if same { UNSEEN } else { "survived" }.into()
        });
        unseen += usize::from(outcome == UNSEEN);
        if outcome != NONE && outcome != UNSEEN {
            found.push((outcome, key));
        }
    }
    println!("{}: {unseen} set aside that change no picture of the scenes", part.name);
    found
}

/// What tells the pictures apart that random scenes have by the shaders of a folder, or by the program's own.
fn pictures(tests: &Tests, variable: Option<(&str, &str)>) -> BTreeSet<String> {
    let (program, case) = PICTURES;
    let mut command = Command::new(&tests.executables[program]);
    command.args(["--ignored", "--exact", case, "--nocapture"]).envs(variable);
    let log = tests.tree.with_file_name("pictures.log");
    let file = fs::File::create(&log).expect("a log");
    command.current_dir(&tests.tree).stdout(file).status().expect("the program starts");
    let log = fs::read_to_string(log).expect("a log");
    let digests: BTreeSet<String> =
        log.lines().filter(|line| line.starts_with("picture ")).map(str::to_string).collect();
    assert!(variable.is_some() || digests.len() > 50, "{} pictures", digests.len());
    digests
}
