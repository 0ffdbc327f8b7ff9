"""The cases: a name, and the commands whose outputs are recorded.

Commands are words between spaces. The first is `ofx` for the test host with the plugin, `c_abi` for c_abi.py, or a
command of `seidel`. The others may contain
    {plates} {psf} {gap}       folders with data
    {lens[NAME]}               the profile written by the case fit/NAME, or the one in the folder --lenses
    {made[NAME]}               an input from inputs.py
    {out}                      an empty folder; every file in it is an output
    {library}                  the library with the C ABI
A command that ends with `> FILE` has its standard output written there.
"""

from dataclasses import dataclass

# Outputs that are not recorded: pictures with lettering.
UNCHECKED = ("demo/sheet.png", "demo/before-after.png")

SETS = ("zemax-dgauss28", "optiland-us8879901", "dash-stars", "prime50", "prime50-decentred", "ana-front-31")
GAPS = ("open_0_defocus_offset", "open_1_decentre", "open_2_motion", "open_3_vignetting", "open_4_none")


@dataclass
class Case:
    name: str
    commands: tuple


def fit(name, line):
    """A fit whose profile other cases use as {lens[NAME]}."""
    return Case(f"fit/{name}", (f"fit {line} -o {{out}}/lens.json --json > {{out}}/report.json",))


def fits():
    for name in SETS:
        yield fit(f"{name}-moments", f"{{psf}}/{name} --model moments")
    yield fit("zemax-dgauss28-unweighted", "{psf}/zemax-dgauss28 --model moments --unweighted --all-pixels")
    yield fit("dash-stars-moments-free", "{psf}/dash-stars --model moments --axis free")
    yield fit("zemax-dgauss28-reduced", "{psf}/zemax-dgauss28 --model reduced")
    yield fit("optiland-us8879901-reduced", "{psf}/optiland-us8879901 --model reduced")
    yield fit("dash-stars-reduced", "{psf}/dash-stars --model reduced")
    yield fit("prime50-reduced", "{psf}/prime50 --model reduced")
    yield fit("prime50-law", "{psf}/prime50 --model reduced --law-only --use-all")
    yield fit("prime50-extended", "{psf}/prime50 --model extended")
    yield fit("zemax-dgauss28-extended", "{psf}/zemax-dgauss28 --model extended --only {made[quarter.txt]}")
    for name in GAPS:
        yield fit(name, f"{{gap}}/{name}/design")


def apply(name, line):
    return Case(f"apply/{name}", (f"apply {line} -o {{out}}/out.exr {BARE}",))


# Without a record of version and command.
BARE = "--no-provenance"
ZEMAX = "--lens {lens[zemax-dgauss28-reduced]}"
OPTILAND = "--lens {lens[optiland-us8879901-reduced]}"
DEMO = "--lens {lens[demo]}"
MOMENTS = "--lens {lens[zemax-dgauss28-moments]}"
RGB_MOMENTS = "--lens {lens[optiland-us8879901-moments]}"
MOTORCYCLE = "{plates}/motorcycle.exr"
BEACHBALL = "{plates}/beachball.exr"
CAMERA = "{plates}/camera-512.exr"
LAMPS = "{plates}/lamps.exr"
ELEMENT = "{plates}/element.exr"
CROP = "{made[crop.exr]}"
CUTOUT = "{made[cutout.exr]}"


def applications():
    # With depth, ray by ray.
    motorcycle = f"{ZEMAX} {MOTORCYCLE}"
    yield apply("motorcycle/final", motorcycle)
    yield apply("motorcycle/draft", f"{motorcycle} --quality draft")
    yield apply("motorcycle/no-occlusion", f"{motorcycle} --occlusion off")
    yield apply("motorcycle/black", f"{motorcycle} --edges black")
    yield apply("motorcycle/extend", f"{motorcycle} --edges extend --quality draft")
    yield apply("motorcycle/focus", f"{motorcycle} --focus-distance 2.4 --f-number 5.6")
    yield apply("motorcycle/sensor", f"{motorcycle} --sensor-shift-um 300 --quality draft")
    controls = "--depth-of-field 0.5 --front-multiplier 1.5 --back-multiplier 0.5 --maximum-size 4"
    yield apply("motorcycle/focus-controls", f"{motorcycle} {controls}")
    yield apply("motorcycle/holdout", f"{motorcycle} --holdout {{made[matte.exr]}}:A")
    holdout = "--holdout {made[matte.exr]}:A --holdout-depth {made[matte.exr]}:Z"
    yield apply("motorcycle/holdout-depth", f"{motorcycle} {holdout} --quality draft")
    yield apply("motorcycle/foreground", f"{motorcycle} --no-fill-foreground --no-blur-inside --quality draft")
    yield apply("motorcycle/flat", f"{motorcycle} --distance 2.1")
    yield apply("motorcycle/large", f"{motorcycle} --distance 2.1 --lens-scale 1")
    yield apply("motorcycle/offset", f"{motorcycle} --distance 5 --axis-offset 120,-60 --amount 1.7")
    yield apply("motorcycle/anamorphic", f"{motorcycle} --distance 2.1 --pixel-aspect 2 --quality draft")
    # Three channels of their own.
    colour = f"{OPTILAND} {MOTORCYCLE} --distance 6 --lens-scale 0.5"
    yield apply("colour/lateral", colour)
    yield apply("colour/none", f"{colour} --geometry none")
    yield apply("colour/full", f"{colour} --geometry full")
    yield apply("colour/scales", f"{colour} --channel-scale R=1.3,B=0.7 --quality draft")
    yield apply("colour/full-depth", f"{OPTILAND} {MOTORCYCLE} --depth-unit 4 --geometry full --lens-scale 0.5")
    # By moments, with each PSF model.
    moments = f"{MOMENTS} {MOTORCYCLE}"
    yield apply("moments/final", moments)
    yield apply("moments/draft", f"{moments} --quality draft")
    yield apply("moments/no-occlusion", f"{moments} --occlusion off")
    yield apply("moments/flat", f"{moments} --distance 2.1 --edges black")
    for model in ("gaussian", "skew-normal", "skew-normal-general", "skew-normal-eq43", "mirrored-pair"):
        yield apply(f"models/{model}", f"{moments} --distance 5.5 --psf {model}")
    yield apply("models/rays-as-skew-normal", f"{motorcycle} --distance 2.1 --psf skew-normal")
    # Alpha.
    beachball = f"{OPTILAND} {BEACHBALL}"
    yield apply("beachball/final", beachball)
    yield apply("beachball/draft-per-channel", f"{beachball} --alpha-per-channel --quality draft")
    yield apply("beachball/moments", f"{RGB_MOMENTS} {BEACHBALL} --alpha-per-channel")
    yield apply("beachball/flat", f"{beachball} --distance 10 --edges extend")
    yield apply("element/final", f"{DEMO} {ELEMENT}")
    yield apply("element/per-channel", f"{DEMO} {ELEMENT} --alpha-per-channel")
    yield apply("element/unpremultiplied", f"{DEMO} {ELEMENT} --alpha unpremultiplied --occlusion off")
    yield apply("element/draft", f"{DEMO} {ELEMENT} --quality draft --edges black")
    # Lights, and a data window apart from the display window.
    lamps = f"{DEMO} {LAMPS} --focus-distance 6 --f-number 2.8"
    yield apply("lamps/final", lamps)
    yield apply("lamps/draft", f"{lamps} --quality draft")
    yield apply("lamps/wide-open", f"{DEMO} {LAMPS} --no-fill-foreground")
    yield apply("lamps/no-occlusion", f"{DEMO} {LAMPS} --occlusion off")
    # One distance, one channel.
    yield apply("camera/stars", f"--lens {{lens[dash-stars-reduced]}} {CAMERA} --lens-scale 0.5")
    yield apply("camera/stars-draft", f"--lens {{lens[dash-stars-reduced]}} {CAMERA} --quality draft")
    yield apply("camera/stars-moments", f"--lens {{lens[dash-stars-moments]}} {CAMERA} --lens-scale 1")
    yield apply("camera/prime", f"--lens {{lens[prime50-extended]}} {CAMERA} --distance 2")
    yield apply("camera/anamorphic", f"--lens {{lens[ana-front-31-moments]}} {CAMERA} --distance 3")
    yield apply("camera/extended", f"--lens {{lens[zemax-dgauss28-extended]}} {CAMERA} --distance 2.1")
    # Every pixel with its own kernel.
    exact = f"{CROP} --lens-scale 0.2 --quality exact"
    yield apply("exact/rays", f"{ZEMAX} {exact}")
    yield apply("exact/rays-colour", f"{DEMO} {exact} --occlusion off --geometry full")
    yield apply("exact/rays-flat", f"{ZEMAX} {exact} --distance 2.1 --edges black")
    yield apply("exact/moments", f"{MOMENTS} {exact} --edges extend")
    yield apply("exact/moments-flat", f"{MOMENTS} {exact} --distance 5.5 --psf mirrored-pair")
    alpha = "--depth-unit 4 --lens-scale 0.5 --quality exact --alpha-per-channel"
    yield apply("exact/alpha", f"{RGB_MOMENTS} {CUTOUT} {alpha}")
    # Depth conventions.
    crop = f"{ZEMAX} {CROP} --lens-scale 0.3"
    yield apply("depth/inverse", f"{crop} --depth {{made[inverse.exr]}}:Z --depth-kind inverse")
    normalised = f"{crop} --depth {{made[normalised.exr]}}:Z --near 2 --far 6"
    yield apply("depth/far-one", f"{normalised} --depth-kind far-one")
    yield apply("depth/far-zero", f"{normalised} --depth-kind far-zero")
    yield apply("depth/along-ray", f"{crop} --along-ray 100")
    yield apply("depth/feet", f"{crop} --depth-unit ft --no-depth-check")
    # Sequences, formats and colour.
    sequence = "{made[frames]}/crop.%04d.exr --frames 1-3 --animate {made[values.csv]} -o {out}/out.%04d.exr"
    yield Case("apply/sequence", (f"apply {ZEMAX} --lens-scale 0.3 {sequence} {BARE}",))
    endings = ("png", "tif", "dpx", "hdr")
    options = f"{DEMO} --lens-scale 0.3 {BARE}"
    written = tuple(f"apply {options} {CUTOUT} -o {{out}}/out.{ending}" for ending in endings)
    back = tuple(f"apply {options} {{out}}/out.{ending} --distance 3 -o {{out}}/{ending}.exr" for ending in endings)
    yield Case("apply/formats", written + back)
    spaces = "--ocio seidel --in-space vlog --out-space logc4 --working-space ACEScg"
    yield apply("colour-spaces", f"{DEMO} {CROP} --lens-scale 0.3 {spaces}")


def remove(name, line, *then):
    return Case(f"remove/{name}", (f"remove {line} -o {{out}}/out.exr {BARE}", *then))


def removals():
    stars = "--lens {lens[dash-stars-moments]} --lens-scale 1"
    maps = "--residual {out}/residual.exr --confidence {out}/confidence.exr --noise-gain {out}/noise-gain.exr"
    back = f"apply {stars} {{out}}/out.exr --residual {{out}}/residual.exr -o {{out}}/back.exr {BARE}"
    yield remove("camera", f"{stars} {CAMERA} --lens-check off {maps}", back)
    rays = "--lens {lens[dash-stars-reduced]} --lens-scale 0.5 --no-overscan --grain solved"
    yield remove("camera-rays", f"{rays} {CAMERA} --lens-check off")
    lens = f"{ZEMAX} --distance 2.1 --lens-scale 0.3"
    yield Case("remove/checked", (
        f"apply {lens} {CAMERA} --amount 0.8 -o {{out}}/blurred.exr {BARE}",
        f"remove {lens} {{out}}/blurred.exr -o {{out}}/out.exr {BARE}",
    ))
    options = "--noise 0.005 --clip 0.9 --strength 0.7 --lens-check off --confidence {out}/confidence.exr"
    yield remove("depth", f"{ZEMAX} {MOTORCYCLE} {options}")
    yield remove("colour", f"{OPTILAND} {MOTORCYCLE} --distance 6 --lens-scale 0.4 --geometry full")
    yield remove("lamps", f"{DEMO} {LAMPS} --distance 4 --lens-check warn {maps}")
    yield remove("alpha", f"{DEMO} {ELEMENT} --distance 3 --alpha-per-channel --lens-check off")
    for name, source, target, line in (
        ("camera", "dash-stars-moments", "prime50-reduced", f"{CAMERA} --distance 2.4"),
        ("depth", "zemax-dgauss28-moments", "demo", MOTORCYCLE),
    ):
        lenses = f"--from {{lens[{source}]}} --to {{lens[{target}]}}"
        yield Case(f"relens/{name}", (f"relens {lenses} {line} --lens-check off -o {{out}}/out.exr {BARE}",))


def evaluations():
    for lens, name in (
        ("zemax-dgauss28-moments", "zemax-dgauss28"),
        ("zemax-dgauss28-reduced", "zemax-dgauss28"),
        ("optiland-us8879901-moments", "optiland-us8879901"),
        ("optiland-us8879901-reduced", "optiland-us8879901"),
        ("dash-stars-moments", "dash-stars"),
        ("dash-stars-reduced", "dash-stars"),
        ("prime50-extended", "prime50-decentred"),
        ("ana-front-31-moments", "ana-front-31"),
    ):
        command = f"eval --lens {{lens[{lens}]}} {{psf}}/{name} --json > {{out}}/report.json"
        yield Case(f"eval/{lens}", (command,))
    report = "--json > {out}/report.json"
    sparse = "--lens {lens[zemax-dgauss28-moments]} {psf}/zemax-dgauss28 --sparse --splits 4"
    yield Case("eval/sparse", (f"eval {sparse} {report}",))
    picture = f"--lens {{lens[dash-stars-moments]}} {{psf}}/dash-stars --image {CAMERA}"
    yield Case("eval/picture", (f"eval {picture} {report}",))


def psf(name, line):
    return Case(f"psf/{name}", (f"psf {line} --out {{out}}/set",))


def predictions():
    yield psf("zemax-rays", f"{ZEMAX} --like {{psf}}/zemax-dgauss28")
    yield psf("zemax-moments", f"{MOMENTS} --like {{psf}}/zemax-dgauss28")
    yield psf("zemax-stopped-down", f"{ZEMAX} --like {{psf}}/zemax-dgauss28 --f-number 5.6 --focus-distance 2.5")
    yield psf("optiland-rays", f"{OPTILAND} --like {{psf}}/optiland-us8879901")
    yield psf("optiland-skew-normal", f"{OPTILAND} --like {{psf}}/optiland-us8879901 --psf skew-normal")
    yield psf("optiland-gaussian", f"{RGB_MOMENTS} --like {{psf}}/optiland-us8879901 --psf gaussian")
    yield psf("dash-stars", "--lens {lens[dash-stars-reduced]} --like {psf}/dash-stars")
    yield psf("prime50", "--lens {lens[prime50-extended]} --like {psf}/prime50")
    yield psf("gap", "--lens {lens[open_1_decentre]} --like {gap}/open_1_decentre/holdout")


def diagnoses():
    out = "--out {out}/report"
    for name in GAPS:
        yield Case(f"diagnose/{name}", (f"diagnose --lens {{lens[{name}]}} {{gap}}/{name}/real {out}",))
    prime = "--lens {lens[prime50-reduced]} {psf}/prime50-decentred"
    yield Case("diagnose/decentred-prime", (f"diagnose {prime} --only decentre,sensor_tilt,motion --no-pairs {out}",))
    pair = "--reference {made[texture.exr]} --observed {out}/plate.exr --depth-m 3"
    yield Case("diagnose/pictures", (
        f"apply {DEMO} {{made[texture.exr]}} --distance 3 --f-number 4 -o {{out}}/plate.exr {BARE}",
        f"diagnose {DEMO} {pair} --only defocus_offset --no-pairs {out}",
    ))


def tables():
    lut = "lut --ocio seidel"
    yield Case("lut/tables", (
        f"{lut} --in-space logc4 --out-space ACEScg --size 17 -o {{out}}/logc4.cube",
        f"{lut} --in-space ACEScg --view sRGB/Plain --size 9 --range 0,4 -o {{out}}/shown.cube",
        f"{lut} --in-space ACEScg --out-space ACEScct --size 1024 -o {{out}}/curve.spi1d",
    ))
    yield Case("lut/pictures", (
        f"{lut} {CROP} --in-space ACEScg --out-space vlog -o {{out}}/vlog.exr {BARE}",
        f"{lut} {{out}}/vlog.exr --in-space vlog --out-space ACEScg -o {{out}}/back.exr {BARE}",
        f"{lut} {CROP} --in-space ACEScg --view sRGB/Plain -o {{out}}/shown.png {BARE}",
    ))


def c_abi():
    for name in ("demo", "zemax-dgauss28-reduced", "optiland-us8879901-moments"):
        yield Case(f"c-abi/kernels/{name}", (f"c_abi kernels {{library}} {{lens[{name}]}} {{out}}",))
    for name in ("demo", "zemax-dgauss28-reduced"):
        yield Case(f"c-abi/plates/{name}", (f"c_abi plates {{library}} {{lens[{name}]}} {{out}} {CROP}",))
    yield Case("c-abi/removal", (
        f"c_abi removal {{library}} {{lens[demo]}} {{lens[zemax-dgauss28-reduced]}} {{out}} {LAMPS}",
    ))


def host(name, line):
    return Case(f"host/{name}", (f"ofx --render {{out}}/out.exr {line}",))


def hosts():
    feeds = f"--feed Source={LAMPS} --feed Depth={LAMPS}:Z --set math=depth --set worldScale=metres"
    crop = f"--feed Source={CROP} --feed Depth={CROP}:Z --set math=depth --set worldScale=metres --set lensScale=0.3"
    file = "--set lens=Lens\\ File --set profile={lens[demo]}"
    for short, lens in (
        ("fast-50", "Fast\\ 50\\ mm\\ f/0.95"),
        ("fast-35", "Fast\\ 35\\ mm\\ f/1.4"),
        ("portrait-85", "Portrait\\ 85\\ mm\\ f/1.4"),
        ("vintage-58", "Vintage\\ 58\\ mm\\ f/2"),
    ):
        yield host(f"grid/{short}", f"{feeds} --set lens={lens} --set output=PSF\\ Grid")
        yield host(f"apply/{short}", f"{crop} --set lens={lens}")
    yield host("grid/file", f"{feeds} {file} --set output=PSF\\ Grid")
    yield host("grid/flat", f"--feed Source={MOTORCYCLE} {file} --set distance=1.5 --set output=PSF\\ Grid")
    yield host("apply/lamps", f"{feeds} {file} --overlay")
    for kind in ("nuke", "resolve", "natron"):
        yield host(f"apply/{kind}", f"{crop} {file} --host {kind} --set useDepth=on")
    yield host("focal-plane", f"{feeds} {file} --set output=Focal\\ Plane\\ Setup --set dof=0.3")
    focus = "--set focus=Focus\\ Distance --set focusDistance=3 --set fStop=2 --set front=1.5 --set maxSize=8"
    yield host("apply/focus", f"{feeds} {file} {focus} --set quality=Draft")
    yield host("apply/element", f"--feed Source={ELEMENT} {file} --set distance=3 --set edge=Black --set mix=0.6")
    remove = f"--feed Source={LAMPS} {file} --set distance=4 --set noise=0.01"
    yield host("remove/result", f"{remove} --set mode=Remove")
    yield host("remove/confidence", f"{remove} --set mode=Remove --set output=Confidence")
    yield host("remove/noise-gain", f"{remove} --set mode=Remove --set output=Noise\\ Gain")
    yield host("relens", f"{remove} --set mode=Relens --set toLens=Vintage\\ 58\\ mm\\ f/2")
    yield host("codes", f"--feed Source={LAMPS} {file} --set distance=4 --set sourceCodes=sRGB")


def every():
    """Returns all cases in the order in which they are recorded."""
    demo = Case("demo", ("demo {out}",))
    groups = (
        *(fits(), [demo], applications(), removals(), evaluations()),
        *(predictions(), diagnoses(), tables(), c_abi(), hosts()),
    )
    return [case for group in groups for case in group]
