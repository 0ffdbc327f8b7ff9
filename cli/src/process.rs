//! This process as the system reports it: ignored signals and processor time, from the `/proc` file system of Linux.

use std::path::Path;

use seidel_image_io::json::read_text;

/// Limit of the length of a file of `/proc`, bytes.
const LIMIT_BYTES: u64 = 1 << 20;

/// Ticks per second of the times in `/proc`: `USER_HZ`, which is 100 on every architecture that Rust supports well.
const TICKS_PER_SECOND: f64 = 100.0;
/// Positions of user and system time in `/proc/self/stat`, counted from the field after the command's name.
const USER: usize = 11;
const SYSTEM: usize = 12;

/// Returns the signals that the process was started to ignore, as a mask whose bit 0 is signal 1; `None` without `/proc`.
#[cfg(unix)]
pub(crate) fn ignored_signals() -> Option<u64> {
    ignored_mask(&read_text(Path::new("/proc/self/status"), LIMIT_BYTES).ok()?)
}

/// Returns the mask of ignored signals in the status of a process.
#[cfg(unix)]
fn ignored_mask(status: &str) -> Option<u64> {
    let mut masks = status
        .lines()
        .filter_map(|line| line.strip_prefix("SigIgn:"));
    u64::from_str_radix(masks.next()?.trim(), 16).ok()
}

/// Returns the processor time that all threads of this process have used, in seconds; `None` without `/proc`.
pub(crate) fn processor_seconds() -> Option<f64> {
    seconds(&read_text(Path::new("/proc/self/stat"), LIMIT_BYTES).ok()?)
}

fn seconds(stat: &str) -> Option<f64> {
    // The name is in parentheses and may itself hold spaces and parentheses.
    let (_, fields) = stat.rsplit_once(')')?;
    let fields: Vec<&str> = fields.split_whitespace().collect();
    let ticks = |index: usize| fields.get(index)?.parse::<f64>().ok();
    Some((ticks(USER)? + ticks(SYSTEM)?) / TICKS_PER_SECOND)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[cfg(unix)]
    fn the_mask_of_ignored_signals_is_found() {
        let status = "Name:\tx\nSigBlk:\t0000000000000002\nSigIgn:\t0000000000001001\nSigCgt:\t0\n";
        assert_eq!(ignored_mask(status), Some(0x1001));
        assert_eq!(ignored_mask("Name:\tx\n"), None);
    }

    #[test]
    fn user_and_system_time_are_added() {
        let stat = "41 (a (b) c) S 1 41 41 0 -1 4194560 310 0 0 0 1234 66 0 0 20 0 3 0 8 9";
        assert_eq!(seconds(stat), Some(13.0));
        assert_eq!(seconds("41 (a) S 1"), None);
    }

    #[test]
    #[cfg(target_os = "linux")]
    fn work_takes_processor_time() {
        let before = processor_seconds().expect("there is /proc");
        let mut sum = 0.0_f64;
        while processor_seconds().expect("there is /proc") - before < 0.02 {
            sum += (0..100_000).map(|i| f64::from(i).sqrt()).sum::<f64>();
        }
        assert!(sum > 0.0);
    }
}
