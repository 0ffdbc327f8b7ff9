//! Results that are kept from one render to the next.

use crate::WHOLE;
use crate::host::Host;
use crate::plate::{inverse_depth, plate};

#[test]
fn a_kept_result_is_mixed_anew() {
    let host = Host::new();
    let (source, blurred) = (plate(), host.render(&plate(), WHOLE));
    host.set("mix", 0.5);
    let mixed = host.render(&source, WHOLE);
    for (k, mixed) in mixed.samples.iter().enumerate() {
        let (before, after) = (source.samples[k], blurred.samples[k]);
        assert_eq!(*mixed, before + (after - before) * 0.5);
    }
}

#[test]
fn a_change_of_any_input_is_another_render() {
    let host = Host::new();
    let source = plate();
    let blurred = host.render(&source, WHOLE);
    let mut brighter = source.clone();
    brighter.samples[5] += 1.0;
    assert_ne!(host.render(&brighter, WHOLE).samples, blurred.samples);
    host.set("amount", 0.5);
    assert_ne!(host.render(&source, WHOLE).samples, blurred.samples);
    host.set("amount", 1.0);
    host.connect("Depth", Some(inverse_depth(1)));
    host.choose("math", "far=0");
    assert_ne!(host.render(&source, WHOLE).samples, blurred.samples);
    host.connect("Depth", None);
    host.render(&source, WHOLE).assert_same(&blurred, "again");
}
