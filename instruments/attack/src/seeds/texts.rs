//! Inputs that are text.

use seidel_colour::EMBEDDED_CONFIG;

/// Animation tables, CSV and JSON.
pub(crate) fn animations() -> Vec<Vec<u8>> {
    vec![
        b"frame,focus-distance,f-number\n1001,2.0,2.8\n1005,,4\n1010,inf,5.6\n".to_vec(),
        b"frame,distance\n-3,1.5\n0,2\n4,3e1\n".to_vec(),
        br#"{"1001": {"focus-distance": 1.5, "amount": 1}, "1010": {"focus-distance": "inf"}}"#
            .to_vec(),
    ]
}

/// Tables of lens settings, one of each dialect.
pub(crate) fn lens_tables() -> Vec<Vec<u8>> {
    let tables = [
        "Index\tMaster TC\tLens Distance Unit\tLens Focus Distance\tLens Focal Length\tLens Iris\tLens Linear Iris\n\
         0\t13:36:49:07\tMeter\t4.812\t40.000\t1.4 + 7/10\t2667\n1\t13:36:49:08\tFeet\t10\t40.000\t2\t--\n",
        "FrameNo,Timecode,Aperture,Focus Distance,Focal Length\n0,23:17:21:08,5.6,410,40\n1,23:17:21:09,5.6,420,40\n",
        "\"Timecode\",\"Clip Name\",\"Lens Model\",\"Focal Length (mm)\",\"Aperture\",\"Focus Distance (ft)\"\n\
         \"16:47:04:19\",\"D001\",\"7032\",\"32\",\"T 2 3/10\",\"10\"\n",
        "Timecode,FocusPosition,FocalLength,ApertureNumber,ApertureMode\n0:00:00:00,3F000000,180/10,45/10,2\n0:00:00:01,7F800000,20,4,1\n",
        "Clip Metadata\nlens_type: 50mm\n\nFrame 0 Metadata\naperture: T2.3\nfocal_length: 50mm\ndistance: 991mm\n",
        r#"{"protocol": {"name": "OpenTrackIO", "version": [0, 9, 3]}, "timing": {"sequenceNumber": 7,
           "timecode": {"hours": 1, "minutes": 2, "seconds": 3, "frames": 4}},
           "lens": {"focusDistance": 10.0, "fStop": 4.0, "entrancePupilOffset": 0.123}}"#,
        r#"{"lens": {"focusDistance": [2.0, 2.5], "fStop": [2.8, 2.8]}, "timing": {"sequenceNumber": [1001, 1002]}}"#,
    ];
    tables.map(|table| table.as_bytes().to_vec()).into()
}

/// Frame lists.
pub(crate) fn frame_lists() -> Vec<Vec<u8>> {
    let lists = ["1001-1100", "1-20x3", "1,5,9", "-5-5", "7", "1-3,8-12x2,40"];
    lists.map(|list| list.as_bytes().to_vec()).into()
}

/// Frame patterns.
pub(crate) fn patterns() -> Vec<Vec<u8>> {
    let patterns = [
        "plate.%04d.exr",
        "plate.####.exr",
        "a%db/%%c.exr",
        "plate.exr",
        "shot_##/x.%8d.dpx",
    ];
    patterns.map(|pattern| pattern.as_bytes().to_vec()).into()
}

/// OpenColorIO configs: the program's own, and a short one with most kinds of transforms.
pub(crate) fn configs() -> Vec<Vec<u8>> {
    let short = "ocio_profile_version: 2.1\nstrictparsing: true\nroles:\n  default: ACEScg\n  scene_linear: ACEScg\n\
        file_rules:\n  - !<Rule> {name: Log, colorspace: Camera, pattern: \"*log*\", extension: \"*\"}\n  \
        - !<Rule> {name: Default, colorspace: default}\n\
        displays:\n  sRGB:\n    - !<View> {name: Film, colorspace: Display}\n\
        colorspaces:\n  - !<ColorSpace>\n    name: ACEScg\n    aliases: [acescg, lin]\n  - !<ColorSpace>\n    name: Camera\n    \
        to_scene_reference: !<GroupTransform>\n      children:\n        - !<LogCameraTransform> {base: 2, \
        log_side_slope: 0.25, log_side_offset: 0.38, lin_side_slope: 5.5, lin_side_offset: 0.05, \
        lin_side_break: 0.01, direction: inverse}\n        - !<MatrixTransform> {matrix: [0.6, 0.3, 0.1, 0, 0.1, 0.8, \
        0.1, 0, 0, 0.1, 0.9, 0, 0, 0, 0, 1]}\n  - !<ColorSpace>\n    name: Display\n    \
        from_scene_reference: !<GroupTransform>\n      children:\n        - !<CDLTransform> {slope: [1.1, 1, 0.9], \
        offset: [0, 0.01, 0], power: [1, 1.1, 1], sat: 0.9}\n        - !<ExponentTransform> {value: [2.2, 2.2, 2.2, 1], \
        direction: inverse}\n        - !<RangeTransform> {min_in_value: 0, min_out_value: 0, max_in_value: 1, \
        max_out_value: 1}\n";
    vec![
        short.as_bytes().to_vec(),
        EMBEDDED_CONFIG.as_bytes().to_vec(),
    ]
}

/// Cube tables of one and three dimensions.
pub(crate) fn cubes() -> Vec<Vec<u8>> {
    let mut three =
        "TITLE \"a table\"\nLUT_3D_SIZE 3\nDOMAIN_MIN 0 0 0\nDOMAIN_MAX 1 1 1\n".to_owned();
    for k in 0..27 {
        let level = |step: usize| (k / step % 3) as f32 * 0.5;
        three += &format!("{} {} {}\n", level(1), level(3), level(9));
    }
    let one = "LUT_1D_SIZE 4\n0 0 0\n0.2 0.3 0.25\n0.6 0.7 0.65\n1 1 1\n";
    vec![three.into_bytes(), one.as_bytes().to_vec()]
}

/// A table of one dimension.
pub(crate) fn spi1d() -> Vec<Vec<u8>> {
    vec![
        b"Version 1\nFrom 0.0 1.0\nLength 4\nComponents 1\n{\n0\n0.2\n0.7\n1\n}\n".to_vec(),
        b"Version 1\nFrom -0.1 2.0\nLength 3\nComponents 3\n{\n0 0 0\n0.2 0.3 0.4\n1 1 1\n}\n"
            .to_vec(),
    ]
}
