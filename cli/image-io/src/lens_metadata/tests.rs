//! Twins of the tables of each maker, with their values, and with faults that must be named.

use std::path::Path;

use super::*;
use crate::error::Result;

fn opened(text: &str) -> Result<Sidecar> {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("table");
    std::fs::write(&path, text).expect("writable");
    Sidecar::open(&path)
}

const ARRI: &str = "Index\tMaster TC\tLens Model\tLens Distance Unit\tLens Focus Distance\tLens Focal Length\tLens Iris\tLens Linear Iris\n\
    0\t13:36:49:07\tSP40\tMeter\t4.812\t40.000\t1.4 + 7/10\t2667\n\
    1\t13:36:49:08\tSP40\tFeet\t10\t40.000\t1.4 + 7/10\t--\n";
const RED: &str = "FrameNo,Timecode,Timestamp,Aperture,Focus Distance,Focal Length\n\
    0,23:17:21:08,,5.600000,410,40\n1,23:17:21:09,,5.600000,420,40\n";
const SONY: &str = "\"Timecode\",\"Clip Name\",\"Lens Model\",\"Focal Length (mm)\",\"Aperture\",\"Focus Distance (ft)\"\n\
    \"16:47:04:19\",\"D001\",\"7032\",\"32\",\"T 2 3/10\",\"10\"\n";
const CANON: &str = "Timecode,FocusPosition,FocalLength,ApertureNumber,ApertureMode\n\
    0:00:00:00,3F000000,180/10,45/10,2\n0:00:00:01,7F800000,65535/65535,4,1\n";
const BLACKMAGIC: &str = "Clip Metadata\nlens_type: Cooke 50mm\n\nFrame 0 Metadata\naperture: T2.3\nfocal_length: 50mm\ndistance: 991mm\n\
    \nFrame 1 Metadata\naperture: f2.8\nfocal_length: 50mm\ndistance: 1.5m\n";
const SAMPLE: &str = r#"{"protocol": {"name": "OpenTrackIO", "version": [0, 9, 3]},
    "static": {"camera": {"activeSensorPhysicalDimensions": {"width": 36.0}}, "lens": {"nominalFocalLength": 24}},
    "timing": {"sequenceNumber": 7, "timecode": {"hours": 1, "minutes": 2, "seconds": 3, "frames": 4}},
    "lens": {"focusDistance": 10.0, "fStop": 4.0, "tStop": 4.1, "pinholeFocalLength": 24.305, "entrancePupilOffset": 0.123, "custom": [1]}}"#;
const CLIP: &str = r#"{"lens": {"focusDistance": [2.0, 2.5], "fStop": [2.8, 2.8]}, "timing": {"sequenceNumber": [1001, 1002]}}"#;

/// Focus, f-number or T-number, focal length and film back of a record; 0 where there is none.
fn values(record: &FrameRecord) -> [f64; 4] {
    Quantity::ALL.map(|quantity| record.preferred(quantity, None).map_or(0.0, |r| r.value))
}

#[test]
fn every_dialect_gives_its_values() {
    for (text, expected) in [
        (
            ARRI,
            vec![
                [4.812, 1.782_003_29, 40.0, 0.0],
                [3.048, 1.802_500_93, 40.0, 0.0],
            ],
        ),
        (RED, vec![[0.41, 5.6, 40.0, 0.0], [0.42, 5.6, 40.0, 0.0]]),
        (SONY, vec![[3.048, 2.219_138_94, 32.0, 0.0]]),
        (
            CANON,
            vec![[0.5, 4.5, 18.0, 0.0], [f64::INFINITY, 4.0, 0.0, 0.0]],
        ),
        (
            BLACKMAGIC,
            vec![[0.991, 2.3, 50.0, 0.0], [1.5, 2.8, 50.0, 0.0]],
        ),
        (SAMPLE, vec![[10.0, 4.0, 24.305, 36.0]]),
        (CLIP, vec![[2.0, 2.8, 0.0, 0.0], [2.5, 2.8, 0.0, 0.0]]),
    ] {
        let table = opened(text).expect(text);
        let found: Vec<[f64; 4]> = table.records().iter().map(values).collect();
        assert_eq!(found, expected, "{}", table.dialect());
    }
    let list = format!("[{SAMPLE}, {SAMPLE}]");
    assert_eq!(opened(&list).expect("a list").records().len(), 2);
    let table = opened(SAMPLE).expect("sound");
    let record = &table.records()[0];
    assert_eq!(
        record.time_code.map(|code| code.to_string()).as_deref(),
        Some("01:02:03:04")
    );
    assert_eq!(record.number, Some(7));
    let focus = record.preferred(Quantity::Focus, None).expect("stated");
    assert_eq!(record.usable_value(focus, None), 9.877);
    let t_stops = |text| {
        opened(text)
            .expect("sound")
            .records()
            .iter()
            .flat_map(|r| r.readings.clone())
            .filter(|r| r.is_t_stop)
            .count()
    };
    assert_eq!([BLACKMAGIC, CANON, SAMPLE].map(t_stops), [1, 1, 1]);
}

#[test]
fn three_faults_of_every_dialect_are_named_by_place() {
    let sample = |from: &str, to: &str| SAMPLE.replace(from, to);
    for (text, expected) in [
        (
            ARRI.replace("4.812", "4.8x2"),
            "line 2, column `Lens Focus Distance`",
        ),
        (ARRI.replace("Meter", "Yard"), "unit `Yard`"),
        (
            ARRI.replace("Lens Focal Length", "Focal"),
            "column `Lens Focal Length`: is missing",
        ),
        (
            ARRI.trim_end().trim_end_matches("\t--").to_owned(),
            "line 3: is not a whole row",
        ),
        (RED.replace("410", "nan"), "`nan` is not a number"),
        (
            RED.replace("Focus Distance", "Focus"),
            "column `Focus Distance`: is missing",
        ),
        (
            RED.replace("23:17:21:09", "late"),
            "line 3, column `Timecode`",
        ),
        (SONY.replace("(ft)", "(yd)"), "unit `yd`"),
        (
            SONY.replace("T 2 3/10", "T 2.3 3/10"),
            "`T 2.3 3/10` is not a stop",
        ),
        (SONY.replace(",\"10\"", ""), "line 2: is not a whole row"),
        (
            CANON.replace("3F000000", "7FC00000"),
            "`7FC00000` is not the bits of a number",
        ),
        (CANON.replace("45/10", "0/0"), "`0/0` is not a stop"),
        (
            CANON.replace("ApertureMode", "Mode"),
            "column `ApertureMode`: is missing",
        ),
        (
            BLACKMAGIC.replace("991mm", "991"),
            "line 7, `distance`: `991` has no known unit",
        ),
        (BLACKMAGIC.replace("T2.3", "wide"), "`wide` is not a stop"),
        (
            BLACKMAGIC.replace("Frame 1", "Frame one"),
            "`one` is not a frame number",
        ),
        (
            sample("10.0", "\"ten\""),
            "sample 0, lens.focusDistance: is \"ten\", not a number",
        ),
        (
            sample("[0, 9, 3]", "[2, 0, 0]"),
            "protocol.version: is [2,0,0]",
        ),
        (
            sample("OpenTrackIO", "FreeD"),
            "protocol.name: is not OpenTrackIO",
        ),
        (SAMPLE[..SAMPLE.len() - 9].to_owned(), "line 4, column"),
        (sample("10.0", "NaN"), "line 4, column"),
        (
            CLIP.replace("[2.8, 2.8]", "[2.8]"),
            "lens.fStop: has 1 values, but /lens/focusDistance has 2",
        ),
        (
            CLIP.replace("focusDistance", "focusPosition")
                .replace("fStop", "iris"),
            "holds no lens settings",
        ),
        (
            "frame,amount\n1,2\n".to_owned(),
            "is no table of lens settings that is known",
        ),
    ] {
        let message = opened(&text).expect_err(expected).to_string();
        assert!(
            message.contains("table") && message.contains(expected),
            "{expected}: {message}"
        );
        assert!(message.contains(';'), "a remedy: {message}");
    }
    let other = SAMPLE.replace("\"static\"", "\"sourceNumber\": 2, \"static\"");
    let two = format!(
        "{}\n{other}",
        other.replace("\"sourceNumber\": 2", "\"sourceNumber\": 1")
    );
    let message = opened(&two).expect_err("two cameras").to_string();
    assert!(
        message.contains("sample 1, sourceNumber: is 2, but 1"),
        "{message}"
    );
}

#[test]
fn stops_lengths_and_time_codes_are_read_as_makers_write_them() {
    let stop = |text| number::parse_stop(text).map(|stop| number::decimal(stop.value));
    assert_eq!(stop("f/2.8"), Some(2.8));
    assert_eq!(stop("T5.6"), Some(5.6));
    assert_eq!(stop("4"), Some(4.0));
    assert_eq!(stop("5.6 + 0/10"), Some(5.656_854_25));
    assert_eq!(["", "T", "1.4 + x", "nan", "3 1/10"].map(stop), [None; 5]);
    let length =
        |text| number::parse_length(text).map(|length| (length.value, length.unit.to_owned()));
    assert_eq!(length("991mm"), Some((991.0, "mm".to_owned())));
    assert_eq!(length("5.83 ft"), Some((5.83, "ft".to_owned())));
    assert_eq!(length("Infinity"), Some((f64::INFINITY, String::new())));
    assert_eq!(["mm", "", "nan", "1m2"].map(length), [const { None }; 4]);
    let code = |text| TimeCode::parse(text).map(|code| code.to_string());
    assert_eq!(
        code("1:02:03;04 drop frame").as_deref(),
        Some("01:02:03:04")
    );
    assert_eq!(
        ["", "1:2:3", "24:00:00:00", "1:2:3:4:5", "a:b:c:d"].map(code),
        [const { None }; 5]
    );
}

#[test]
fn far_distances_are_doubted_unless_the_file_states_their_unit() {
    let lens = |focal, f_number| Optics {
        focal_length_mm: Some(focal),
        f_number: Some(f_number),
    };
    let doubt = |optics: Optics, value, unit| optics.check(Quantity::Focus, value, unit).is_some();
    assert!(doubt(lens(40.0, 5.6), 410.0, UnitSource::Defined));
    assert!(doubt(lens(50.0, 2.3), 991.0, UnitSource::Defined));
    assert!(!doubt(lens(50.0, 2.3), 991.0, UnitSource::Stated));
    assert!(!doubt(lens(500.0, 4.0), 991.0, UnitSource::Defined));
    assert!(!doubt(lens(40.0, 5.6), 41.0, UnitSource::Defined));
    assert!(!doubt(lens(40.0, 5.6), f64::INFINITY, UnitSource::Defined));
    assert!(doubt(lens(40.0, 5.6), 0.04, UnitSource::Stated));
    assert!(doubt(Optics::default(), 1e18, UnitSource::Stated));
}

#[test]
fn tables_of_other_frames_are_refused() {
    let table = opened(RED).expect("sound");
    let code = |text| TimeCode::parse(text);
    let frames = |numbers: &[(i64, Option<TimeCode>)]| {
        let frame = |(number, time_code): &(i64, Option<TimeCode>)| ShotFrame {
            number: Some(*number),
            time_code: *time_code,
        };
        numbers.iter().map(frame).collect::<Vec<_>>()
    };
    let by = |frames: &[ShotFrame], start| match_frames(&table, frames, start).map(|m| m.rule);
    let sound = frames(&[(1001, code("23:17:21:08")), (1002, code("23:17:21:09"))]);
    assert_eq!(by(&sound, None).expect("matched"), "by time code");
    let other = frames(&[(0, code("23:17:21:10")), (1, code("23:17:21:11"))]);
    let message = by(&other, None).expect_err("other frames").to_string();
    assert!(
        message.contains("no frame of time code 23:17:21:10") && message.contains("23:17:21:08 to"),
        "{message}"
    );
    assert!(by(&other, Some(0)).expect("matched").contains("at frame 0"));
    assert!(by(&other, Some(1)).is_err());
    // One time code for all frames tells none apart.
    let same = frames(&[(0, code("23:17:21:10")), (1, code("23:17:21:10"))]);
    assert_eq!(by(&same, None).expect("matched"), "by frame number");
    assert!(
        by(&frames(&[(1001, None), (1002, None)]), None)
            .expect("matched")
            .starts_with("in order")
    );
    assert!(by(&frames(&[(1001, None), (1003, None)]), None).is_err());
    assert!(by(&frames(&[(1001, None)]), None).is_err());
    let still = ShotFrame {
        number: None,
        time_code: None,
    };
    let sample = opened(SAMPLE).expect("sound");
    assert!(match_frames(&sample, &[still], None).is_ok());
    assert!(match_frames(&table, &[still], None).is_err());
}

/// Starts of valid tables to damage.
const SOUND: [&str; 7] = [ARRI, RED, SONY, CANON, BLACKMAGIC, SAMPLE, CLIP];

proptest::proptest! {
    #[test]
    fn damaged_tables_are_read_or_refused(
        which in 0..SOUND.len(),
        changes in proptest::collection::vec((proptest::prelude::any::<proptest::sample::Index>(), proptest::prelude::any::<u8>()), 0..6),
        end in proptest::prelude::any::<proptest::sample::Index>(),
    ) {
        let mut bytes = SOUND[which].as_bytes().to_vec();
        for (at, byte) in changes {
            let at = at.index(bytes.len());
            bytes[at] = byte;
        }
        bytes.truncate(end.index(bytes.len()) + 1);
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("table");
        std::fs::write(&path, bytes).expect("writable");
        match Sidecar::open(&path) {
            Ok(table) => {
                let records = table.records().iter().zip(0..).map(|(record, frame)| ShotRecord {
                    frame,
                    file: Path::new("table").to_owned(),
                    record: record.clone(),
                });
                let records: Vec<ShotRecord> = records.collect();
                if let Ok(found) = columns(&records, &Quantity::ALL, ShotUse::default()) {
                    proptest::prop_assert!(found.columns.iter().all(|c| c.values.values().all(|v| *v > 0.0)));
                }
                range_lines(table.records());
            }
            Err(error) => {
                let message = error.to_string();
                proptest::prop_assert!(message.contains("table") && message.contains("; "), "{}", message);
            }
        }
    }
}

#[test]
fn a_table_with_a_column_twice_is_described() {
    let table = opened(&RED.replace("Timestamp", "Aperture")).expect("a table");
    let lines = range_lines(table.records());
    assert!(!lines.is_empty());
    let record = &table.records()[0];
    let mut twice = record.clone();
    twice.readings.extend(record.readings.clone());
    assert!(range_lines(&[twice])[0].contains("first frame"));
}
