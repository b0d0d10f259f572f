//! The validation layer keeps its table of instances and devices without a lock (Vulkan-ValidationLayers, issue 4391): a call that
//! looks there while another thread makes or ends one may crash. So one is made, or ended, while no other test calls Vulkan.

use std::cell::RefCell;
use std::sync::{PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

static CALLS: RwLock<()> = RwLock::new(());

enum Held {
    Shared(#[allow(dead_code, reason = "held")] RwLockReadGuard<'static, ()>),
    Whole(#[allow(dead_code, reason = "held")] RwLockWriteGuard<'static, ()>),
}

thread_local! {
    static HELD: RefCell<Option<Held>> = const { RefCell::new(None) };
}

fn share() {
    HELD.set(Some(Held::Shared(CALLS.read().unwrap_or_else(PoisonError::into_inner))));
}

/// What this thread may do until it is dropped.
#[must_use]
pub enum Turn {
    /// What it might before.
    Nested,
    Outer {
        was_shared: bool,
    },
}

/// It may call Vulkan, beside others.
pub fn beside() -> Turn {
    if HELD.with_borrow(Option::is_some) {
        return Turn::Nested;
    }
    share();
    Turn::Outer { was_shared: false }
}

/// It may make and end instances and devices, and is alone.
pub fn alone() -> Turn {
    if HELD.with_borrow(|held| matches!(held, Some(Held::Whole(_)))) {
        return Turn::Nested;
    }
    // Freed first: another may wait for this thread.
    let was_shared = HELD.take().is_some();
    HELD.set(Some(Held::Whole(CALLS.write().unwrap_or_else(PoisonError::into_inner))));
    Turn::Outer { was_shared }
}

impl Drop for Turn {
    fn drop(&mut self) {
        if let Self::Outer { was_shared } = self {
            HELD.set(None);
            if *was_shared {
                share();
            }
        }
    }
}
