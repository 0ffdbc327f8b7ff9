//! Names of render passes: which are beauty, depth, or other data.
//!
//! Names are compared in lower case, without spaces and punctuation.

/// The name of a pass and the program that writes it.
pub(super) struct PassName {
    /// The name, in lower case, letters and digits alone.
    pub(super) name: &'static str,
    /// The program or standard.
    pub(super) source: &'static str,
}

const fn row(name: &'static str, source: &'static str) -> PassName {
    PassName { name, source }
}

/// Names of the layer or part that holds the finished picture.
const BEAUTY: [PassName; 14] = [
    row("rgba", "Nuke, Arnold and V-Ray"),
    row("rgb", "Nuke"),
    row("beauty", "Arnold, Redshift and Octane"),
    row("main", "Nuke's default view"),
    row("c", "Houdini (Mantra and Karma)"),
    row("ci", "RenderMan"),
    row("combined", "Blender"),
    row("image", "Blender's file output node"),
    row("rgbcolor", "V-Ray"),
    row("vrayrgba", "V-Ray"),
    row("rgbacolor", "V-Ray"),
    row("finalimage", "Unreal"),
    row("color", "Hydra and Karma"),
    row("colour", "Hydra and Karma"),
];

/// Names of the channel, layer or part that holds depth.
const DEPTH: [PassName; 12] = [
    row("z", "OpenEXR, Arnold, Redshift and RenderMan"),
    row("depth", "Nuke, Blender and Redshift"),
    row("zdepth", "V-Ray and Octane"),
    row("vrayzdepth", "V-Ray"),
    row("pz", "Houdini (Mantra)"),
    row("hitpz", "Houdini (Karma)"),
    row("depthz", "Nuke, with an underscore for the dot"),
    row("zpass", "3ds Max and Maya"),
    row("zbuffer", "3ds Max and Cinema 4D"),
    row("worlddepth", "Unreal"),
    row("finalimagemovierenderqueueworlddepth", "Unreal"),
    row("cgeometryzdepth", "Corona"),
];

/// Names of passes that are not the finished picture: geometry, identifiers, masks, and parts of the light.
const OTHER: [&str; 82] = [
    // Geometry.
    "n",
    "nn",
    "ng",
    "normal",
    "normals",
    "shadingnormal",
    "smoothnormal",
    "bumpnormal",
    "bumpnormals",
    "geometricnormal",
    "worldnormal",
    "vraynormals",
    "p",
    "pworld",
    "pref",
    "pos",
    "position",
    "point",
    "worldposition",
    "uv",
    "uvs",
    "st",
    "texcoord",
    "vector",
    "vrayvelocity",
    "velocity",
    "forward",
    "backward",
    "disparity",
    "disparityl",
    "disparityr",
    "tangent",
    "curvature",
    "facingratio",
    // Identifiers and masks.
    "id",
    "ids",
    "indexob",
    "indexma",
    "objectid",
    "materialid",
    "vrayobjectid",
    "vraymtlid",
    "matte",
    "mattes",
    "mask",
    "masks",
    "holdout",
    "holdouts",
    "puzzlematte",
    "coverage",
    "crypto",
    "alpha",
    // Parts of the light.
    "albedo",
    "diffuse",
    "diffusealbedo",
    "diffcol",
    "diffdir",
    "diffind",
    "diffusedirect",
    "diffuseindirect",
    "specular",
    "specularalbedo",
    "glosscol",
    "glossdir",
    "glossind",
    "transcol",
    "transdir",
    "transind",
    "reflection",
    "refraction",
    "emission",
    "emit",
    "env",
    "environment",
    "shadow",
    "shadows",
    "ao",
    "ambientocclusion",
    "sss",
    "gi",
    "globalillumination",
    "mist",
];

/// Parts of the names of such passes: Cryptomatte, and vectors of motion.
const OTHER_WORDS: [&str; 2] = ["crypto", "motio"];

/// Returns `name` in lower case, letters and digits alone.
fn normalised(name: &str) -> String {
    let letters = name.chars().filter(|c| c.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

fn find(table: &'static [PassName], name: &str) -> Option<&'static str> {
    let name = normalised(name);
    table
        .iter()
        .find(|row| row.name == name)
        .map(|row| row.source)
}

/// Returns the programs that call a beauty pass `name`; `None` if no program known here does.
pub(super) fn beauty_source(name: &str) -> Option<&'static str> {
    find(&BEAUTY, name)
}

/// Returns the programs that call a depth pass `name`; `None` if no program known here does.
pub(super) fn depth_source(name: &str) -> Option<&'static str> {
    find(&DEPTH, name)
}

/// Returns whether a layer or part called `name` may hold depth although no known program calls it so: its name contains
/// "depth", and not that of another kind of pass.
pub(super) fn resembles_depth(name: &str) -> bool {
    let name = normalised(name);
    let other = ["denois", "mask", "matte", "id", "normal", "albedo"];
    name.contains("depth") && !other.iter().any(|word| name.contains(word))
}

/// Returns whether a layer or part called `name` holds something else than the finished picture.
pub(super) fn is_other(name: &str) -> bool {
    let name = normalised(name);
    OTHER.contains(&name.as_str())
        || OTHER_WORDS.iter().any(|word| name.contains(word))
        || depth_source(&name).is_some()
        || resembles_depth(&name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_normalised_and_no_pass_is_two_things() {
        let tables = BEAUTY.iter().chain(&DEPTH).map(|row| row.name);
        for name in tables.chain(OTHER) {
            assert_eq!(normalised(name), name);
        }
        for row in &BEAUTY {
            assert!(!is_other(row.name), "{}", row.name);
        }
        for row in &DEPTH {
            assert!(!OTHER.contains(&row.name), "{}", row.name);
        }
    }
}
