//! Removal of blur, another lens's blur in its place, and the mix with the source.

use crate::WHOLE;
use crate::host::Host;
use crate::plate::plate;
use crate::rig::Rig;

#[test]
fn removal_and_relens() {
    let mut rig = Rig::new();
    rig.abi.settings.distance = 10.0;
    rig.host.choose("mode", "Remove");
    (rig.rendered()).assert_same(&rig.abi.remove(&plate(), WHOLE), "remove");
    rig.host.choose("mode", "Relens");
    (rig.rendered()).assert_same(&rig.abi.relens(&plate(), WHOLE), "relens");
}

#[test]
fn a_removal_is_mixed_with_the_source() {
    let host = Host::new();
    host.choose("mode", "Remove");
    let (before, after) = (plate(), host.render(&plate(), WHOLE));
    host.set("mix", 0.25);
    let mixed = host.render(&plate(), WHOLE);
    for (k, mixed) in mixed.samples.iter().enumerate() {
        let (before, after) = (before.samples[k], after.samples[k]);
        assert!((mixed - (before + (after - before) * 0.25)).abs() < 1e-6);
    }
}
