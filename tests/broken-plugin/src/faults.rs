//! The faults.

use std::ffi::CStr;

macro_rules! faults {
    ($($name:ident $id:literal, $about:literal;)*) => {
        /// What a variant does wrong.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Fault {
            $(#[doc = $about] $name,)*
        }

        const ALL: &[Fault] = &[$(Fault::$name),*];

        /// How many variants there are.
        pub(crate) const COUNT: usize = ALL.len();

        /// Their identifiers.
        pub(crate) const IDS: [&CStr; COUNT] = [$($id),*];
    };
}

faults! {
    None c"org.seidel.box.correct", "Nothing.";
    UnreleasedImage c"org.seidel.box.unreleasedImage", "The image of Source is not released.";
    DoubleRelease c"org.seidel.box.doubleRelease", "The image of Source is released twice.";
    WritesOutside c"org.seidel.box.writesOutside", "The row above the window is written, too.";
    LeavesPixel c"org.seidel.box.leavesPixel", "The last pixel of the window is not written.";
    NegativeRows c"org.seidel.box.negativeRows", "Negative row bytes are taken for positive ones from the same memory.";
    SmallRegion c"org.seidel.box.smallRegion", "The region of interest is the window alone.";
    SmallDefinition c"org.seidel.box.smallDefinition", "The region of definition is Source's, though the blur goes beyond.";
    KeepsString c"org.seidel.box.keepsString", "A string of the host is read after the next call.";
    FalseIdentity c"org.seidel.box.falseIdentity", "Small blurs are said to change nothing.";
    ReadsUntimed c"org.seidel.box.readsUntimed", "Render reads a parameter without a time.";
    ThreadDependent c"org.seidel.box.threadDependent", "The first row of each thread's share is brighter.";
    StaleState c"org.seidel.box.staleState", "The second load blurs more than the first.";
    FatalProperty c"org.seidel.box.fatalProperty", "Load fails where the host does not say its API version.";
    FormatMessage c"org.seidel.box.formatMessage", "A message is its own format.";
    KeepsMessage c"org.seidel.box.keepsMessage", "The persistent message is never cleared.";
    IgnoresScale c"org.seidel.box.ignoresScale", "The blur has as many pixels at any render scale.";
    WrongAspect c"org.seidel.box.wrongAspect", "Wide pixels make the blur wider.";
    LingeringThread c"org.seidel.box.lingeringThread", "A thread outlives Unload.";
    WrongReply c"org.seidel.box.wrongReply", "Unknown actions are said to fail.";
    NullData c"org.seidel.box.nullData", "An image without data is read.";
    NullMember c"org.seidel.box.nullMember", "A member of a suite is called that may be NULL.";
    NullSuite c"org.seidel.box.nullSuite", "An optional suite is used that may be missing.";
    NullInstance c"org.seidel.box.nullInstance", "Instance data are read that may be missing.";
    LeaksInstance c"org.seidel.box.leaksInstance", "Instance data are never freed.";
    IgnoresAbort c"org.seidel.box.ignoresAbort", "The render asks whether to stop, and goes on.";
    MixesFields c"org.seidel.box.mixesFields", "A field is made of the rows of both.";
    Seams c"org.seidel.box.seams", "The blur is cut off at the edges of the window.";
    SharedScratch c"org.seidel.box.sharedScratch", "Renders at the same time share a variable.";
    WrongChannel c"org.seidel.box.wrongChannel", "Depth is taken from the last channel.";
    StaleParameter c"org.seidel.box.staleParameter", "The size is kept, and read anew only when told of a change.";
    WrongOrigin c"org.seidel.box.wrongOrigin", "The picture is shaded by where it lies.";
    Accumulates c"org.seidel.box.accumulates", "Every render is brighter than the one before.";
    RefusesSmall c"org.seidel.box.refusesSmall", "Pictures of one column are refused.";
    BadDefault c"org.seidel.box.badDefault", "The default of a parameter lies outside its range.";
    NoLabel c"org.seidel.box.noLabel", "The plugin has no label.";
    DoesNothing c"org.seidel.box.doesNothing", "The blur is never put on.";
    ClearsAlways c"org.seidel.box.clearsAlways", "Messages are cleared where the function for it points to nowhere.";
    MaskedOnly c"org.seidel.box.maskedOnly", "Nothing is written where the mask has no pixels.";
    ClearsDestroyed c"org.seidel.box.clearsDestroyed", "Messages are cleared when the instance is destroyed.";
    NeedsRegion c"org.seidel.box.needsRegion", "Nothing is asked for where Source has no region yet.";
    TakesAnySamples c"org.seidel.box.takesAnySamples", "Samples are floats, whatever the host says they are.";
    TrustsRegion c"org.seidel.box.trustsRegion", "Source ends where its region says, whatever its image has.";
    WideThreads c"org.seidel.box.wideThreads", "Wide blurs depend on the number of threads.";
}

impl Fault {
    /// The fault of that number.
    pub(crate) fn of(n: usize) -> Self {
        ALL.get(n).copied().unwrap_or(Self::None)
    }
}
