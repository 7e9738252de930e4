//! Processes, told apart across hosts and restarts, so that what a dead one left behind can be recognised.

use std::sync::OnceLock;

/// A process that uses a store: its host, the host's boot and process space, its number and when it started.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Process {
    /// Name of the host, in letters that fit a file name.
    pub host: String,
    /// Tells boots, and spaces in which process numbers mean something, apart; empty where the system does not say.
    space: String,
    /// Its number.
    pub pid: u32,
    /// When it started, in the system's ticks since its boot; 0 where the system does not say.
    start: u64,
}

/// Whether a process is still there.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Life {
    /// It runs.
    Running,
    /// It is gone.
    Gone,
    /// It cannot be asked: it runs, or ran, on another host or in another space of processes.
    Unknown,
}

impl Process {
    /// This process.
    pub fn this() -> &'static Self {
        static THIS: OnceLock<Process> = OnceLock::new();
        THIS.get_or_init(|| {
            let pid = std::process::id();
            Self { host: system::host(), space: system::space(), pid, start: system::start(pid).unwrap_or(0) }
        })
    }

    /// A name for files of this process, to which [`Process::of_name`] is the way back.
    pub fn name(&self) -> String {
        let Self { host, space, pid, start } = self;
        format!("{host}~{space}~{pid}~{start}")
    }

    /// The process that made the file called `name`.
    pub fn of_name(name: &str) -> Option<Self> {
        let mut parts = name.split('~');
        let (host, space) = (parts.next()?.to_owned(), parts.next()?.to_owned());
        let (pid, start) = (parts.next()?.parse().ok()?, parts.next()?.parse().ok()?);
        Some(Self { host, space, pid, start })
    }

    /// Whether it is still there.
    pub fn life(&self) -> Life {
        let this = Self::this();
        if self.host != this.host || self.space != this.space {
            return Life::Unknown;
        }
        match system::start(self.pid) {
            // Another process may have got the number of one that is gone.
            Some(start) if start == self.start => Life::Running,
            Some(_) => Life::Gone,
            None => system::signalled(self.pid),
        }
    }
}

/// `name` in letters that fit any file name, and never the one that parts names.
fn plain(name: &str) -> String {
    name.chars().map(|c| if c.is_ascii_alphanumeric() || matches!(c, '-' | '.') { c } else { '_' }).collect()
}

#[cfg(unix)]
mod system {
    use super::{Life, plain};
    use std::fs;
    use wire::Digest;

    pub fn host() -> String {
        plain(&rustix::system::uname().nodename().to_string_lossy())
    }

    /// On Linux, the boot and the space of process numbers, which containers of one host do not share.
    pub fn space() -> String {
        let boot = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
        let space = fs::read_link("/proc/self/ns/pid").unwrap_or_default();
        if boot.is_empty() {
            return String::new();
        }
        Digest::of(format!("{boot}{}", space.display()).as_bytes()).hex()[..8].to_owned()
    }

    /// When process `pid` started, where it runs and the system says so.
    pub fn start(pid: u32) -> Option<u64> {
        let stat = fs::read_to_string(format!("/proc/{pid}/stat")).ok()?;
        // The second field is a name in brackets, which may hold anything; the third is the state, the 22nd the start.
        let mut fields = stat.rsplit_once(')')?.1.split_whitespace();
        let gone = matches!(fields.next()?, "Z" | "X");
        if gone { Some(u64::MAX) } else { fields.nth(18)?.parse().ok() }
    }

    /// Whether process `pid` takes signals, where nothing else is known of it.
    pub fn signalled(pid: u32) -> Life {
        let Some(pid) = i32::try_from(pid).ok().and_then(rustix::process::Pid::from_raw) else { return Life::Gone };
        match rustix::process::test_kill_process(pid) {
            Err(rustix::io::Errno::SRCH) => Life::Gone,
            _ => Life::Running,
        }
    }
}

#[cfg(not(unix))]
mod system {
    use super::{Life, plain};

    pub fn host() -> String {
        plain(&std::env::var("COMPUTERNAME").unwrap_or_default())
    }

    pub fn space() -> String {
        String::new()
    }

    pub fn start(_pid: u32) -> Option<u64> {
        None
    }

    pub fn signalled(_pid: u32) -> Life {
        Life::Unknown
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn this_process_runs_and_its_name_leads_back() {
        let this = Process::this();
        assert_eq!(Process::of_name(&this.name()).as_ref(), Some(this));
        assert_eq!(Process::of_name(&format!("{}~7", this.name())).as_ref(), Some(this));
        assert_eq!(Process::of_name("12-3"), None);
        if cfg!(target_os = "linux") {
            assert_eq!(this.life(), Life::Running);
            let reborn = Process { start: this.start + 1, ..this.clone() };
            assert_eq!(reborn.life(), Life::Gone, "the number alone proves nothing");
        }
        let elsewhere = Process { host: "elsewhere".into(), ..this.clone() };
        assert_eq!(elsewhere.life(), Life::Unknown);
    }
}
