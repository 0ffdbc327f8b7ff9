//! The choice of channels in files of several programs.

use super::*;

/// Returns parts from texts such as `rgba.left@left: R G B`; `@` is the attribute `view`, `[..]` the attribute `multiView`.
fn parts(texts: &[&str]) -> Vec<PartNames> {
    let part = |text: &&str| {
        let (head, channels) = text.split_once(": ").expect("channels");
        let (head, views) = head.split_once('[').unwrap_or((head, ""));
        let (name, view) = head.split_once('@').unwrap_or((head, ""));
        let some = |text: &str| (!text.is_empty()).then(|| text.to_owned());
        PartNames {
            name: some(name),
            view: some(view),
            views: views
                .trim_end_matches(']')
                .split_whitespace()
                .map(str::to_owned)
                .collect(),
            channels: channels
                .split('/')
                .flat_map(str::split_whitespace)
                .map(|c| c.replace('+', " "))
                .collect(),
        }
    };
    texts.iter().map(part).collect()
}

fn name(parts: &[PartNames], place: ChannelPlace) -> String {
    let part = &parts[place.part];
    let channel = &part.channels[place.channel];
    match &part.name {
        Some(name) if parts.len() > 1 => format!("{name}:{channel}"),
        _ => channel.clone(),
    }
}

/// Returns the first colour channel of each view with the depth that belongs to it, or what stands against it.
fn chosen(texts: &[&str], layer: Option<&str>, view: &ViewChoice) -> String {
    let parts = parts(texts);
    let selection = Selection::new(&parts);
    let differ = |_, _| false;
    let views = match selection.colour(layer, view) {
        Ok(views) => views,
        Err(NoColour::Several(places)) => {
            let names: Vec<String> = places.into_iter().map(|at| name(&parts, at)).collect();
            return format!("several: {}", names.join(" "));
        }
        Err(problem) => return format!("{problem:?}"),
    };
    let of_view = |own: ColourChoice| {
        let depth = match selection.depth(Some(own.colour[0]), None, &differ) {
            Ok(depth) => name(&parts, depth.place),
            Err(NoDepth::Several(_)) => "several".to_owned(),
            Err(_) => "none".to_owned(),
        };
        format!("{} with {depth}", name(&parts, own.colour[0]))
    };
    let all: Vec<String> = views.into_iter().map(of_view).collect();
    all.join(", ")
}

fn all(texts: &[&str]) -> String {
    chosen(texts, None, &ViewChoice::All)
}

#[test]
fn each_eye_gets_its_own_depth() {
    let root = ["[left right]: R G B Z right.R right.G right.B right.Z"];
    assert_eq!(all(&root), "R with Z, right.R with right.Z");
    let layers = ["[left right]: R G B depth.Z right.R right.G right.B right.depth.Z"];
    assert_eq!(all(&layers), "R with depth.Z, right.R with right.depth.Z");
    let layer_first = ["[left right]: R G B depth.Z right.R right.G right.B depth.right.Z"];
    assert_eq!(
        all(&layer_first),
        "R with depth.Z, right.R with depth.right.Z"
    );
    let parts = [
        "rgba.left@left: R G B",
        "depth.left@left: Z",
        "rgba.right@right: R G B",
        "depth.right@right: Z",
    ];
    let wanted = "rgba.left:R with depth.left:Z, rgba.right:R with depth.right:Z";
    assert_eq!(all(&parts), wanted);
    // The views in another order, and without attributes.
    let order = [
        "depth_right: Z",
        "rgba_right: R G B",
        "depth_left: Z",
        "rgba_left: R G B",
    ];
    assert_eq!(
        all(&order),
        "rgba_right:R with depth_right:Z, rgba_left:R with depth_left:Z"
    );
    let views = ["left@left: R G B depth.Z", "right@right: R G B depth.Z"];
    assert_eq!(
        all(&views),
        "left:R with left:depth.Z, right:R with right:depth.Z"
    );
    for layer in ["right", "rgba.right"] {
        let right = chosen(&parts, Some(layer), &ViewChoice::All);
        assert_eq!(right, "rgba.right:R with depth.right:Z", "{layer}");
    }
    assert_eq!(
        chosen(&root, Some("right"), &ViewChoice::All),
        "right.R with right.Z"
    );
    let right = ViewChoice::Named("Right".into());
    assert_eq!(chosen(&root, None, &right), "right.R with right.Z");
    assert_eq!(chosen(&parts, Some("rgba"), &ViewChoice::All), wanted);
    let middle = ViewChoice::Named("middle".into());
    assert!(chosen(&parts, None, &middle).contains("NoView"));
    // The other eye's depth is never taken.
    let one = [
        "rgba.left@left: R G B",
        "depth.left@left: Z",
        "rgba.right@right: R G B",
    ];
    assert_eq!(
        all(&one),
        "rgba.left:R with depth.left:Z, rgba.right:R with none"
    );
    let shared = [
        "rgba.left@left: R G B",
        "rgba.right@right: R G B",
        "depth: Z",
    ];
    assert_eq!(
        all(&shared),
        "rgba.left:R with none, rgba.right:R with none"
    );
    let unnamed = [": left.R left.G left.B left.Z right.R right.G right.B right.Z"];
    assert_eq!(all(&unnamed), "left.R with left.Z, right.R with right.Z");
    let named_one = [": R G B Z right.R right.G right.B right.Z"];
    assert_eq!(all(&named_one), "R with Z, right.R with right.Z");
    let layer = [
        "[left right]: diffuse.R diffuse.G diffuse.B R G B right.R right.G right.B right.diffuse.R right.diffuse.G right.diffuse.B Z right.Z",
    ];
    let wanted = "diffuse.R with Z, right.diffuse.R with right.Z";
    assert_eq!(chosen(&layer, Some("diffuse"), &ViewChoice::All), wanted);
}

#[test]
fn components_of_vectors_and_depth_of_other_layers_are_not_the_depth() {
    for (texts, wanted) in [
        (
            &[
                "rgba.main@main: R G B",
                "character.main@main: Z red",
                "depth.main@main: Z",
            ][..],
            "rgba.main:R with depth.main:Z",
        ),
        (
            &["rgba: R G B", "character: depth.Z id", "depth: Z"],
            "rgba:R with depth:Z",
        ),
        (
            &["rgba: R G B", "N: X Y Z", "depth: Z"],
            "rgba:R with depth:Z",
        ),
        (&["rgba: R G B", "N: X Y Z"], "rgba:R with none"),
        (&["rgba: R G B", "pointWorld: x y z"], "rgba:R with none"),
        (&["rgba: R G B", "character: Z"], "rgba:R with none"),
        (&["rgba: R G B", "P: Z"], "rgba:R with none"),
        (&["rgba: R G B Z", "depth: Z"], "rgba:R with rgba:Z"),
        (&["rgba: R G B", "depth: Z", "Pz: Y"], "rgba:R with several"),
        (&[": R G B N.X N.Y N.Z Z"], "R with Z"),
        (
            &[": R G B N.X N.Y N.Z P.x P.y P.z depth.Z"],
            "R with depth.Z",
        ),
        (&[": R G B X Y Z"], "R with none"),
        (&[": R G B ZBack Z"], "R with Z"),
        (&[": R G B Mist.Z"], "R with none"),
        (&[": R G B myDepthPass.R"], "R with myDepthPass.R"),
        (&[": R G B depth_mask.R"], "R with none"),
    ] {
        assert_eq!(all(texts), wanted, "{texts:?}");
    }
}

#[test]
fn depth_is_known_by_the_names_of_renderers() {
    for name in [
        "Z",
        "depth.Z",
        "depth",
        "Depth.V",
        "ZDepth.Z",
        "VRayZDepth.R",
        "Z.Z",
        "Pz",
        "depth.R",
        "depth.Y",
        "depth.red",
        "FinalImageMovieRenderQueue_WorldDepth.R",
        "Z+depth.R",
        "CGeometry_ZDepth.R",
        "zbuffer.Z",
    ] {
        let wanted = format!("R with {}", name.replace('+', " "));
        assert_eq!(all(&[&format!(": R G B {name}")]), wanted);
    }
}

#[test]
fn the_beauty_pass_is_known_by_the_names_of_renderers() {
    for (texts, wanted) in [
        (
            &["N: R G B", "albedo: R G B", "C: R G B", "Pz: Y"][..],
            "C:R with Pz:Y",
        ),
        (
            &[
                "N: R G B",
                "albedo: R G B",
                "rgba.main: R G B",
                "depth.main: Z",
            ],
            "rgba.main:R with depth.main:Z",
        ),
        (
            &["N_main: R G B", "rgba_main: R G B", "depth_main: Z"],
            "rgba_main:R with depth_main:Z",
        ),
        (&["albedo: R G B", "Ci: R G B", "z: Z"], "Ci:R with z:Z"),
        (
            &[
                "ViewLayer.Albedo: R G B",
                "ViewLayer.Combined: R G B",
                "ViewLayer.Depth: Z",
            ],
            "ViewLayer.Combined:R with ViewLayer.Depth:Z",
        ),
        (
            &["id: Y", "beauty2: R G B", "depth: Z"],
            "beauty2:R with depth:Z",
        ),
        (
            &["other: Y", "beauty2: R G B", "depth: Z"],
            "beauty2:R with depth:Z",
        ),
        (
            &["first: R G B", "second: R G B"],
            "several: first:R second:R",
        ),
        (&["N: R G B", "P: R G B"], "Missing"),
        (&["N: R G B"], "R with none"),
        (
            &[": ViewLayer.Combined.R ViewLayer.Combined.G ViewLayer.Combined.B ViewLayer.Depth.Z"],
            "ViewLayer.Combined.R with ViewLayer.Depth.Z",
        ),
        (
            &[
                ": View+Layer.Combined.R View+Layer.Combined.G View+Layer.Combined.B View+Layer.Depth.Z View+Layer.Mist.Z",
            ],
            "View Layer.Combined.R with View Layer.Depth.Z",
        ),
        (
            &[
                ": Front.Combined.R Front.Combined.G Front.Combined.B Back.Combined.R Back.Combined.G Back.Combined.B",
            ],
            "several: Front.Combined.R Back.Combined.R",
        ),
        (
            &[": Front.Combined.R Front.Combined.G Front.Combined.B Back.Depth.Z Front.Depth.Z"],
            "Front.Combined.R with Front.Depth.Z",
        ),
        (&[": R G B diffuse.R diffuse.G diffuse.B Z"], "R with Z"),
    ] {
        assert_eq!(all(texts), wanted, "{texts:?}");
    }
}
