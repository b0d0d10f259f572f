//! A process with all that it starts, ended together, also where this program itself is killed: a group of processes on Unix,
//! a job on Windows. Interrupts of the terminal reach this program alone.

pub use of::Tree;

#[cfg(unix)]
mod of {
    use std::io;
    use std::os::unix::process::CommandExt as _;
    use std::process::{Child, Command};

    use nix::sys::signal::{SIGKILL, killpg};
    use nix::unistd::Pid;

    /// The group that a process leads.
    pub struct Tree(Pid);

    impl Tree {
        pub fn start(mut command: Command) -> io::Result<(Child, Self)> {
            command.process_group(0);
            #[cfg(target_os = "linux")]
            // SAFETY: between fork and exec this makes one system call, which is allowed there.
            unsafe {
                // Even if this process is killed, none is left behind.
                command.pre_exec(|| Ok(nix::sys::prctl::set_pdeathsig(SIGKILL)?));
            }
            let child = command.spawn()?;
            let group = Pid::from_raw(child.id() as i32);
            Ok((child, Self(group)))
        }

        pub fn end(&self) {
            // Best effort: it may be ending by itself.
            let _ = killpg(self.0, SIGKILL);
        }
    }
}

#[cfg(windows)]
mod of {
    use std::io;
    use std::os::windows::io::{AsRawHandle as _, FromRawHandle as _, OwnedHandle};
    use std::os::windows::process::CommandExt as _;
    use std::process::{Child, Command};

    use windows_sys::Win32::System::JobObjects::{
        AssignProcessToJobObject, CreateJobObjectW, JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE,
        JOBOBJECT_EXTENDED_LIMIT_INFORMATION, JobObjectExtendedLimitInformation,
        SetInformationJobObject, TerminateJobObject,
    };
    use windows_sys::Win32::System::Threading::CREATE_NEW_PROCESS_GROUP;

    /// A job. Its processes end when its one handle is closed, which the system does for a killed program.
    pub struct Tree(OwnedHandle);

    impl Tree {
        pub fn start(mut command: Command) -> io::Result<(Child, Self)> {
            let job = Self::new()?;
            let mut child = command.creation_flags(CREATE_NEW_PROCESS_GROUP).spawn()?;
            // Left out is what it starts before this call, and itself if this program is killed before it: some microseconds.
            // SAFETY: both handles are open.
            let assigned = whether(unsafe {
                AssignProcessToJobObject(job.0.as_raw_handle(), child.as_raw_handle())
            });
            if let Err(error) = assigned {
                let _ = child.kill();
                let _ = child.wait();
                return Err(error);
            }
            Ok((child, job))
        }

        fn new() -> io::Result<Self> {
            // SAFETY: a job without a name and with the usual rights needs no memory of ours.
            let handle = unsafe { CreateJobObjectW(std::ptr::null(), std::ptr::null()) };
            if handle.is_null() {
                return Err(io::Error::last_os_error());
            }
            // SAFETY: the handle was just made, and nothing else closes it.
            let job = Self(unsafe { OwnedHandle::from_raw_handle(handle) });
            let mut limits = JOBOBJECT_EXTENDED_LIMIT_INFORMATION::default();
            limits.BasicLimitInformation.LimitFlags = JOB_OBJECT_LIMIT_KILL_ON_JOB_CLOSE;
            // SAFETY: the class is that of the structure, which has the size stated.
            whether(unsafe {
                SetInformationJobObject(
                    handle,
                    JobObjectExtendedLimitInformation,
                    (&raw const limits).cast(),
                    size_of_val(&limits) as u32,
                )
            })?;
            Ok(job)
        }

        pub fn end(&self) {
            // Best effort: it may be ending by itself.
            // SAFETY: the handle is open.
            let _ = unsafe { TerminateJobObject(self.0.as_raw_handle(), 1) };
        }
    }

    /// What a call of Windows says by a number.
    fn whether(told: i32) -> io::Result<()> {
        if told == 0 { Err(io::Error::last_os_error()) } else { Ok(()) }
    }
}
