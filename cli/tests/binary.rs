//! The built binary: exit statuses as a shell sees them, a full disk, a closed pipe.

use std::path::Path;
use std::process::{Command, ExitStatus, Output, Stdio};

const SEIDEL: &str = env!("CARGO_BIN_EXE_seidel");

fn run(args: &[&str]) -> Output {
    Command::new(SEIDEL).args(args).output().expect("it starts")
}

#[test]
fn exit_statuses() {
    assert_eq!(run(&["--version"]).status.code(), Some(0));
    assert_eq!(run(&["apply", "--help"]).status.code(), Some(0));
    assert_eq!(run(&["lens", "schema"]).status.code(), Some(0));
    let failed = run(&["lens", "show", "no-such-lens.json", "-o", "sheet.png"]);
    assert_eq!(failed.status.code(), Some(1));
    assert!(String::from_utf8_lossy(&failed.stderr).contains("no-such-lens.json"));
    assert!(!Path::new("sheet.png").exists());
    assert_eq!(run(&["no-such-command"]).status.code(), Some(2));
}

#[test]
fn a_closed_pipe_causes_no_panic() {
    let mut child = Command::new(SEIDEL)
        .args(["lens", "schema"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    drop(child.stdout.take());
    let output = child.wait_with_output().expect("it ends");
    let message = String::from_utf8_lossy(&output.stderr);
    assert!(!message.contains("panicked"), "{message}");
}

/// Renders to a file system of 64 kB that is nearly full: needs the right to mount one.
#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_an_error_that_leaves_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let at = |name: &str| folder.path().join(name);
    std::fs::create_dir(at("small")).expect("writable");
    std::fs::write(at("lens.json"), lens().to_json()).expect("writable");
    // Fine detail, which no codec makes small.
    let grain = |x: usize, y: usize| ((x * 7919 + y * 104_729) % 1009) as f32 / 1009.0;
    exr::prelude::write_rgb_file(at("plate.exr"), 128, 128, |x, y| {
        (grain(x, y), grain(y, x), grain(x + y, x))
    })
    .expect("writable");
    let script = r#"
        mount -t tmpfs -o size=64k none small || exit 77
        head -c 56k /dev/zero > small/filler
        "$0" apply --lens lens.json --distance 2 plate.exr -o small/out.exr > log 2>&1
        echo "status $?" >> log
        ls -A small >> log
    "#;
    let status = Command::new("unshare")
        .args(["--map-root-user", "--mount", "sh", "-c", script, SEIDEL])
        .current_dir(folder.path())
        .stderr(Stdio::null())
        .status();
    if !status.is_ok_and(|s| s.success()) {
        // The test harness hides what passing tests print by `eprintln!`.
        let _ = std::io::Write::write_all(
            &mut std::io::stderr(),
            b"SKIPPED: no right to mount a small file system here\n",
        );
        return;
    }
    let log = std::fs::read_to_string(at("log")).expect("the script wrote it");
    assert!(log.contains("out.exr"), "{log}");
    assert!(log.contains("free"), "no remedy: {log}");
    assert!(log.ends_with("status 1\nfiller\n"), "{log}");
}

#[cfg(target_os = "linux")]
fn lens() -> seidel_core::LensProfile {
    use seidel_core::profile::{LensDescription, MomentsChannel, MomentsPlane, Provenance};
    use seidel_core::{LensProfile, ObjectDistance};
    use seidel_optics::lens::MomentCoefficients;
    LensProfile {
        frame: seidel_core::Frame::new(128, 128, None).expect("valid"),
        pixel_pitch_um: None,
        camera: seidel_core::Camera::default(),
        description: LensDescription::Moments(vec![MomentsChannel {
            name: "Y".into(),
            planes: vec![MomentsPlane {
                distance: ObjectDistance::Unknown,
                s: MomentCoefficients([0.4, 0.1, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]),
                s_sigma: [0.0; 10],
                displacement: None,
                tiles_used: 1,
                tiles_rejected: 0,
            }],
        }]),
        held_out: None,
        provenance: Provenance::default(),
    }
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_cannot_be_written_is_a_failure() {
    for args in [&["lens", "schema"][..], &["--help"], &["apply", "--help"]] {
        let full = std::fs::File::create("/dev/full").expect("a full device");
        let output = Command::new(SEIDEL).args(args).stdout(full).output();
        let output = output.expect("it starts");
        assert_eq!(output.status.code(), Some(1), "{args:?}");
        let message = String::from_utf8_lossy(&output.stderr);
        let expected = "error: standard output: cannot be written (";
        assert!(message.starts_with(expected), "{message}");
    }
}

/// A write beyond the limit of file sizes raises SIGXFSZ, which would end the process and leave a partial file.
#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_file_sizes_is_an_error_that_leaves_no_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let output = Command::new("sh")
        .args([
            "-c",
            r#"ulimit -f 4; "$0" lens export modern-50 -o lens.json"#,
            SEIDEL,
        ])
        .current_dir(&folder)
        .output()
        .expect("it starts");
    let message = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(1), "{message}");
    assert!(message.contains("lens.json"), "{message}");
    let left = std::fs::read_dir(folder.path()).expect("readable").count();
    assert_eq!(left, 0);
}

#[test]
fn profiles_that_cannot_be_used_are_marked() {
    let folder = tempfile::tempdir().expect("a folder");
    let text = lens().to_json();
    std::fs::write(folder.path().join("good.json"), &text).expect("writable");
    let newer = text.replacen("\"version\": 1", "\"version\": 99", 1);
    assert_ne!(newer, text);
    std::fs::write(folder.path().join("newer.json"), newer).expect("writable");
    let listed = Command::new(SEIDEL)
        .args(["lens", "list"])
        .env("SEIDEL_LENSES", folder.path())
        .output()
        .expect("it starts");
    let listed = String::from_utf8_lossy(&listed.stdout);
    let line = |name: &str| {
        listed
            .lines()
            .find(|line| line.starts_with(name))
            .expect("listed")
    };
    assert!(line("library:good").ends_with("own profile"), "{listed}");
    assert!(
        line("library:newer").contains("cannot be used") && listed.contains("99"),
        "{listed}"
    );
}

/// Writes a sequence of frames that takes some seconds, and the lens for it. Returns the arguments of the command.
#[cfg(target_os = "linux")]
fn slow_sequence(folder: &Path) -> Vec<String> {
    std::fs::write(folder.join("lens.json"), lens().to_json()).expect("writable");
    let grain = |x: usize, y: usize| ((x * 7919 + y * 104_729) % 1009) as f32 / 1009.0;
    for frame in 1..=60 {
        exr::prelude::write_rgb_file(folder.join(format!("in.{frame}.exr")), 160, 160, |x, y| {
            (grain(x, y), grain(y, x), grain(x + y, x))
        })
        .expect("writable");
    }
    let at = |name: &str| folder.join(name).to_string_lossy().into_owned();
    let words = "apply --distance 2 --quality exact --frames 1-60 --lens";
    let words = words.split(' ').map(str::to_owned);
    let files = [
        at("lens.json"),
        at("in.%d.exr"),
        "-o".to_owned(),
        at("out.%d.exr"),
    ];
    words.chain(files).collect()
}

/// The names of partial outputs in a folder.
#[cfg(target_os = "linux")]
fn partial_outputs(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten();
    let names = entries.map(|entry| entry.file_name().to_string_lossy().into_owned());
    names.filter(|name| name.ends_with(".part")).collect()
}

/// The command with the signals of a terminal's child. A caller in the background of a shell ignores SIGINT, and the program
/// would do the same.
#[cfg(target_os = "linux")]
fn interruptible() -> Command {
    let mut command = Command::new("env");
    command.args(["--default-signal=INT,HUP,TERM", SEIDEL]);
    command
}

/// Starts the command, sends it `signal` while a partial output exists and returns its exit status.
/// None if it ended before a partial output was seen, as it may on a busy machine.
#[cfg(target_os = "linux")]
fn stop_while_writing(folder: &Path, args: &[String], signal: &str) -> Option<ExitStatus> {
    let mut child = interruptible()
        .args(args)
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("it starts");
    while partial_outputs(folder).is_empty() {
        if child.try_wait().expect("it can be waited for").is_some() {
            return None;
        }
    }
    let sent = Command::new("kill")
        .args([signal, &child.id().to_string()])
        .status();
    assert!(sent.expect("kill runs").success());
    Some(child.wait().expect("it ends"))
}

#[cfg(target_os = "linux")]
#[test]
fn signals_remove_partial_outputs() {
    let folder = tempfile::tempdir().expect("a folder");
    let args = slow_sequence(folder.path());
    for (signal, status) in [("-INT", 130), ("-TERM", 143), ("-HUP", 129)] {
        // A signal may come after the last frame: the program has then ended well.
        let ended = (0..20)
            .filter_map(|_| stop_while_writing(folder.path(), &args, signal))
            .find(|ended| !ended.success())
            .unwrap_or_else(|| panic!("no {signal} came while an output was written"));
        assert_eq!(ended.code(), Some(status), "{signal}");
        assert_eq!(partial_outputs(folder.path()), [""; 0], "{signal}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn outputs_of_a_killed_run_are_removed_by_the_next_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let args = slow_sequence(folder.path());
    // A kill may come a moment after the file got its name.
    let left = (0..20).any(|_| {
        stop_while_writing(folder.path(), &args, "-KILL");
        !partial_outputs(folder.path()).is_empty()
    });
    assert!(left, "no kill left a partial output");
    let quick = args
        .iter()
        .map(|word| if word == "exact" { "draft" } else { word });
    let args: Vec<&str> = quick.collect();
    let output = run(&args);
    assert_eq!(output.status.code(), Some(0), "{output:?}");
    assert_eq!(partial_outputs(folder.path()), [""; 0]);
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_fit_leaves_nothing_behind() {
    use std::io::{BufRead, BufReader};
    let folder = tempfile::tempdir().expect("a folder");
    let demo = folder.path().join("demo");
    let mut child = interruptible()
        .args(["demo", "--width", "64", "--progress", "json"])
        .arg(&demo)
        .stdout(Stdio::null())
        .stderr(Stdio::piped())
        .spawn()
        .expect("it starts");
    let mut stderr = BufReader::new(child.stderr.take().expect("piped"));
    let mut first = String::new();
    stderr.read_line(&mut first).expect("readable");
    assert!(first.contains(r#""task":"fitting"#), "{first}");
    let sent = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status();
    assert!(sent.expect("kill runs").success());
    assert_eq!(child.wait().expect("it ends").code(), Some(130));
    let entries = std::fs::read_dir(folder.path()).expect("a folder");
    assert_eq!(entries.count(), 0);
    // Every line is whole, also the last.
    for line in stderr.lines() {
        let line = line.expect("text");
        assert!(line.starts_with('{') && line.ends_with('}'), "{line}");
    }
}
