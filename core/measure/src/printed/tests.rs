//! Tests of the chart designs.

use super::*;

const A3: Medium = Medium {
    width_mm: 420.0,
    height_mm: 297.0,
    margin_mm: 10.0,
    pixel_mm: None,
};
const VIEWING: Viewing = Viewing {
    distance_m: 2.0,
    focal_mm: 50.0,
    pitch_um: 4.0,
    blur_px: 8.0,
};

#[test]
fn a_pixel_covers_its_projection() {
    // 4 µm at magnification 50 / 1950.
    assert!((VIEWING.px_mm() - 0.156).abs() < 1e-12);
}

#[test]
fn shapes_stay_within_the_margins() {
    let sheets = [
        edges(A3, &VIEWING).expect("room"),
        board(A3, &VIEWING).expect("room"),
        lights(A3, &VIEWING, 1).expect("room"),
    ];
    for sheet in sheets {
        assert!(sheet.shapes.len() > 50, "{}", sheet.caption);
        for [x, y] in sheet.shapes.iter().flat_map(|s| &s.corners) {
            let inside = (10.0..410.0).contains(x) && (10.0..287.0).contains(y);
            assert!(inside, "{}: {x}, {y}", sheet.caption);
        }
    }
}

#[test]
fn edges_of_neighbours_have_four_orientations_off_the_grid() {
    let sheet = edges(A3, &VIEWING).expect("room");
    let mut turns: Vec<i64> = (sheet.shapes[..2].iter())
        .flat_map(|shape| {
            let c = &shape.corners;
            (0..2).map(|k| {
                let [dx, dy] = [c[k + 1][0] - c[k][0], c[k + 1][1] - c[k][1]];
                dy.atan2(dx).to_degrees().rem_euclid(180.0).round() as i64
            })
        })
        .collect();
    turns.sort_unstable();
    assert_eq!(turns, [7, 52, 97, 142]);
}

#[test]
fn a_noise_chart_depends_on_its_seed_alone_and_has_four_marks() {
    let of = |seed| {
        noise(A3, &VIEWING, seed)
            .expect("room")
            .cells
            .expect("cells")
            .cells
    };
    let cells = of(1);
    assert_eq!(cells, of(1));
    assert_ne!(cells, of(2));
    let share = cells.white.iter().filter(|w| **w).count() as f64 / cells.white.len() as f64;
    assert!((0.5..0.65).contains(&share), "{share}");
    // 2 px cells, rings of four cells, two of border: the middle of a mark is black, the ring around it white.
    let at = |x: usize, y: usize| cells.white[y * cells.columns + x];
    let centre = 8 + 14;
    assert!(!at(centre, centre) && at(centre + 8, centre) && !at(centre + 12, centre));
    assert!(!at(cells.columns - 1 - centre, cells.rows - 1 - centre));
    assert!(at(0, 0) && at(7, 100));
}

#[test]
fn lengths_on_a_screen_are_whole_pixels() {
    let screen = Medium {
        width_mm: 600.0,
        height_mm: 337.5,
        margin_mm: 0.0,
        pixel_mm: Some(600.0 / 3840.0),
    };
    let sheet = noise(screen, &VIEWING, 1).expect("room");
    let cell = sheet.cells.expect("cells").cell_mm / (600.0 / 3840.0);
    assert!((cell - cell.round()).abs() < 1e-9 && cell >= 1.0, "{cell}");
}

#[test]
fn impossible_charts_are_refused() {
    let small = Medium {
        width_mm: 40.0,
        height_mm: 30.0,
        ..A3
    };
    for error in [
        noise(small, &VIEWING, 1).expect_err("no room"),
        edges(small, &VIEWING).expect_err("no room"),
        lights(
            small,
            &Viewing {
                blur_px: 60.0,
                ..VIEWING
            },
            1,
        )
        .expect_err("no room"),
    ] {
        assert!(error.to_string().contains("40 x 30 mm"), "{error}");
    }
    let near = Viewing {
        distance_m: 0.05,
        ..VIEWING
    };
    assert!(noise(A3, &near, 1).is_err());
}
