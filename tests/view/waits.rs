//! The window while renderers are prepared: it is there, draws, hears keys, and closes.

use crate::faults::Failing;
use crate::seen::{key, wait_for};

/// Without this call no renderer stands.
const HOLD: &str = "hold vkCreateComputePipelines";

#[test]
fn a_window_that_waits_for_renderers() {
    // That it opens at all, with a title and nothing to draw, is the first thing shown here.
    let mut failing = Failing::open_told(HOLD);
    failing.wait_until_held();
    let seen = &failing.opened.seen;
    let is_stopped = |title: &str| title.ends_with("stopped");
    seen.press(&[key::SPACE]);
    seen.wait_for_title("time runs", |title| !is_stopped(title));
    seen.press(&[key::R]);
    seen.wait_for_title("time stops", is_stopped);
    failing.release();
    let first = failing.opened.seen.screenshot(&[key::F12]);

    // A second model: until it stands, the first goes on.
    failing.tell(HOLD);
    let seen = &failing.opened.seen;
    seen.press(&[key::H]);
    seen.press(&[key::B]);
    failing.wait_until_held();
    seen.press(&[key::SPACE]);
    for _ in 0..3 {
        let before = seen.upper_rows();
        wait_for("the rain falls on", || (before != seen.upper_rows()).then_some(()));
    }
    seen.press(&[key::R]);
    seen.wait_for_title("time stops", is_stopped);
    // What is asked of a picture waits for that picture.
    seen.press(&[key::F12]);
    seen.press(&[key::B]);
    failing.release();
    let split = failing.opened.seen.next_screenshot();
    assert!(first != split, "the screenshot did not wait for the second model");
    let again = failing.opened.seen.screenshot(&[key::F12]);
    assert!(first == again, "the key after the screenshot is lost");

    // Closed, it is gone at once, and ends well when it can.
    failing.tell(HOLD);
    failing.opened.seen.press(&[key::ONE]);
    failing.wait_until_held();
    failing.opened.seen.press(&[key::ESCAPE]);
    wait_for("the window is gone", || (!failing.opened.seen.is_shown()).then_some(()));
    assert!(failing.opened.is_running(), "nothing was held");
    failing.release();
    let status = failing.opened.end();
    assert!(status.success(), "{status}: {}", failing.opened.said());
}
