//! What the keys do: one table, which the window obeys and its help shows.

use winit::keyboard::KeyCode;

/// What a key, or a button of the panel, asks for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    /// Time stops, or goes on.
    Pause,
    /// Time runs the other way; running back it stops where it began.
    Reverse,
    /// Back to where time began.
    Rewind,
    /// One step of time on, or back.
    Step {
        /// On, not back.
        forward: bool,
    },
    /// Time runs faster or slower.
    Rate {
        /// Faster, not slower.
        faster: bool,
    },
    /// Takes the preset of this number.
    Preset(usize),
    /// Twice or half as many drops.
    Drops {
        /// Twice, not half.
        more: bool,
    },
    /// Wipes the pane.
    Wipe,
    /// A brighter or darker picture.
    Exposure {
        /// Brighter, not darker.
        brighter: bool,
    },
    /// Flies up to the nearest drop in front.
    Visit,
    /// A second model beside the first, and their difference.
    Split,
    /// Measures that difference.
    Measure,
    /// Shows or hides the panel.
    Panel,
    /// Keeps what is seen as a picture.
    Screenshot {
        /// With the panel over it.
        panel: bool,
    },
    /// Keeps what is seen as a scene file.
    SaveScene,
    /// Frames wait for the screen, or not.
    Vsync,
    /// Fills the screen, or not.
    Fullscreen,
    /// Compiles the shaders anew.
    Reload,
    /// Closes the window.
    Quit,
}

impl Action {
    /// Whether it is about the picture that this frame draws, and waits for it.
    pub fn is_of_picture(self) -> bool {
        matches!(self, Self::Screenshot { .. } | Self::SaveScene | Self::Measure)
    }

    /// Whether it goes on while its key is held.
    pub fn goes_on(self) -> bool {
        matches!(self, Self::Step { .. } | Self::Exposure { .. })
    }
}

/// A key, whether Shift and Control are held, and what it does.
type Key = (KeyCode, [bool; 2], Action);

const PLAIN: [bool; 2] = [false, false];
const SHIFT: [bool; 2] = [true, false];
const CONTROL: [bool; 2] = [false, true];

const KEYS: [Key; 30] = [
    (KeyCode::Space, PLAIN, Action::Pause),
    (KeyCode::KeyR, PLAIN, Action::Reverse),
    (KeyCode::Home, PLAIN, Action::Rewind),
    (KeyCode::Period, PLAIN, Action::Step { forward: true }),
    (KeyCode::Comma, PLAIN, Action::Step { forward: false }),
    (KeyCode::BracketRight, PLAIN, Action::Rate { faster: true }),
    (KeyCode::BracketLeft, PLAIN, Action::Rate { faster: false }),
    (KeyCode::Digit1, PLAIN, Action::Preset(0)),
    (KeyCode::Digit2, PLAIN, Action::Preset(1)),
    (KeyCode::Digit3, PLAIN, Action::Preset(2)),
    (KeyCode::Digit4, PLAIN, Action::Preset(3)),
    (KeyCode::PageUp, PLAIN, Action::Drops { more: true }),
    (KeyCode::PageDown, PLAIN, Action::Drops { more: false }),
    (KeyCode::Equal, PLAIN, Action::Exposure { brighter: true }),
    (KeyCode::Equal, SHIFT, Action::Exposure { brighter: true }),
    (KeyCode::NumpadAdd, PLAIN, Action::Exposure { brighter: true }),
    (KeyCode::Minus, PLAIN, Action::Exposure { brighter: false }),
    (KeyCode::NumpadSubtract, PLAIN, Action::Exposure { brighter: false }),
    (KeyCode::KeyX, PLAIN, Action::Wipe),
    (KeyCode::KeyF, PLAIN, Action::Visit),
    (KeyCode::KeyB, PLAIN, Action::Split),
    (KeyCode::KeyM, PLAIN, Action::Measure),
    (KeyCode::KeyH, PLAIN, Action::Panel),
    (KeyCode::F12, PLAIN, Action::Screenshot { panel: false }),
    (KeyCode::F12, SHIFT, Action::Screenshot { panel: true }),
    (KeyCode::KeyS, CONTROL, Action::SaveScene),
    (KeyCode::KeyV, PLAIN, Action::Vsync),
    (KeyCode::F11, PLAIN, Action::Fullscreen),
    (KeyCode::F5, PLAIN, Action::Reload),
    (KeyCode::Escape, PLAIN, Action::Quit),
];

/// What a key asks for, if anything.
pub fn action(code: KeyCode, shift: bool, control: bool) -> Option<Action> {
    let held = [shift, control];
    KEYS.iter().find(|(key, with, _)| *key == code && *with == held).map(|(.., action)| *action)
}

/// The keys as the panel and `docs/guide.md` tell them.
pub const HELP: [(&str, &str); 22] = [
    ("W A S D, Q E", "fly; with Shift ten times as fast"),
    ("arrows, drag", "look around"),
    ("wheel", "speed of flight"),
    ("click", "focus on the drop there, if there is an aperture"),
    ("F", "up to the nearest drop in front"),
    ("Space", "stop time, or let it go on"),
    (", and .", "one step back or on"),
    ("[ and ]", "slower (to 1/1000) or faster"),
    ("R", "backwards, to where time began"),
    ("Home", "to where time began, at once"),
    ("1 2 3 4", "presets"),
    ("Page Up, Down", "twice or half as much rain"),
    ("X", "wipe the pane, if rain falls on one"),
    ("+ and -", "exposure"),
    ("B", "a second model beside the first"),
    ("M", "measure how they differ"),
    ("H", "hide or show the panel"),
    ("F12", "screenshot; with Shift the panel too"),
    ("Ctrl S", "scene file of what one sees"),
    ("V, F11", "wait for the screen; fill it"),
    ("F5", "reload the shaders"),
    ("Esc", "close"),
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_key_does_one_thing() {
        for (number, (key, with, _)) in KEYS.iter().enumerate() {
            let again = KEYS[..number].iter().any(|(k, w, _)| k == key && w == with);
            assert!(!again, "{key:?} stands twice");
        }
        assert_eq!(action(KeyCode::KeyS, false, false), None, "S alone flies");
        assert_eq!(action(KeyCode::KeyS, false, true), Some(Action::SaveScene));
    }
}
