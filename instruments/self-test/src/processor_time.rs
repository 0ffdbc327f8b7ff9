//! Processor time of this process, from the `/proc` file system of Linux.

use std::fs::read_to_string;

/// Ticks per second of the times in `/proc`: `USER_HZ`, which is 100 on every architecture that Rust supports well.
const TICKS_PER_SECOND: f64 = 100.0;
/// Positions of user and system time in `/proc/self/stat`, counted from the field after the command's name.
const USER: usize = 11;
const SYSTEM: usize = 12;

/// Returns the processor time that all threads of this process have used, in seconds; `None` without `/proc`.
pub(crate) fn processor_seconds() -> Option<f64> {
    seconds(&read_to_string("/proc/self/stat").ok()?)
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
