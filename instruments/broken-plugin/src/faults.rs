//! The faults that variants of the plugin have.

use openfx::sys::generic::core::OfxPlugin;

macro_rules! faults {
    ($($name:ident $id:literal, $about:literal;)*) => {
        /// A fault of the plugin.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub(crate) enum Fault {
            $(#[doc = $about] $name,)*
        }

        const ALL: &[Fault] = &[$(Fault::$name),*];

        /// The number of variants.
        pub(crate) const COUNT: usize = ALL.len();

        /// The plugins, one for each fault.
        pub(crate) const PLUGINS: [OfxPlugin; COUNT] =
            [$(crate::plugin::<{ Fault::$name as usize }>($id)),*];
    };
}

faults! {
    None c"org.seidel.box.correct", "None: the plugin is correct.";
    UnreleasedImage c"org.seidel.box.unreleasedImage", "Does not release the image of Source.";
    DoubleRelease c"org.seidel.box.doubleRelease", "Releases the image of Source twice.";
    WritesOutside c"org.seidel.box.writesOutside", "Writes the row above the render window.";
    UnwrittenPixel c"org.seidel.box.unwrittenPixel", "Does not write the last pixel of the window.";
    IgnoresNegativeRows c"org.seidel.box.ignoresNegativeRows", "Treats negative row bytes as positive.";
    SmallRegionOfInterest c"org.seidel.box.smallRegionOfInterest", "Asks for the render window only.";
    SmallRegionOfDefinition c"org.seidel.box.smallRegionOfDefinition", "Leaves the region of definition as that of Source.";
    KeepsString c"org.seidel.box.keepsString", "Reads a string of the host after the next call.";
    FalseIdentity c"org.seidel.box.falseIdentity", "Declares small blurs to be the identity.";
    ReadsWithoutTime c"org.seidel.box.readsWithoutTime", "Calls paramGetValue in Render.";
    ThreadDependent c"org.seidel.box.threadDependent", "Brightens the first row of each thread's share.";
    StaleState c"org.seidel.box.staleState", "Blurs more after the second Load.";
    RequiresApiVersion c"org.seidel.box.requiresApiVersion", "Fails to load in hosts that report no API version.";
    MessageAsFormat c"org.seidel.box.messageAsFormat", "Passes the text of a message as its format, with single %.";
    MessageWithArgument c"org.seidel.box.messageWithArgument", "Passes the text of a message as an argument, which prints nothing in Natron.";
    UnlistedGroup c"org.seidel.box.unlistedGroup", "Lists the parameters of a group on a page, and not the group.";
    WidestOutput c"org.seidel.box.widestOutput", "Leaves the components of Output to the host.";
    KeepsFrames c"org.seidel.box.keepsFrames", "Keeps every frame.";
    KeepsMessage c"org.seidel.box.keepsMessage", "Never clears the persistent message.";
    IgnoresScale c"org.seidel.box.ignoresScale", "Blurs by the same number of pixels at every render scale.";
    WrongAspect c"org.seidel.box.wrongAspect", "Multiplies by the pixel aspect ratio instead of dividing.";
    LeftoverThread c"org.seidel.box.leftoverThread", "Leaves a thread running after Unload.";
    WrongReply c"org.seidel.box.wrongReply", "Returns failure for unknown actions.";
    ReadsNullData c"org.seidel.box.readsNullData", "Reads the data of an image that has none.";
    CallsNullFunction c"org.seidel.box.callsNullFunction", "Calls a suite function that is NULL.";
    UsesMissingSuite c"org.seidel.box.usesMissingSuite", "Uses an optional suite that the host lacks.";
    ReadsNullInstance c"org.seidel.box.readsNullInstance", "Reads instance data that do not exist.";
    LeaksInstance c"org.seidel.box.leaksInstance", "Never frees instance data.";
    IgnoresAbort c"org.seidel.box.ignoresAbort", "Calls abort, and goes on whatever it returns.";
    MixesFields c"org.seidel.box.mixesFields", "Renders a field from the rows of both.";
    Seams c"org.seidel.box.seams", "Cuts the blur off at the edges of the render window.";
    SharedState c"org.seidel.box.sharedState", "Shares a variable between concurrent renders.";
    WrongChannel c"org.seidel.box.wrongChannel", "Reads depth from the last channel.";
    StaleParameter c"org.seidel.box.staleParameter", "Keeps the size, and updates it only when notified.";
    WrongOrigin c"org.seidel.box.wrongOrigin", "Makes the picture depend on its position.";
    Accumulates c"org.seidel.box.accumulates", "Brightens every render more than the one before.";
    RejectsNarrow c"org.seidel.box.rejectsNarrow", "Rejects pictures of one column.";
    BadDefault c"org.seidel.box.badDefault", "Gives a parameter a default outside its range.";
    NoLabel c"org.seidel.box.noLabel", "Has no label.";
    DoesNothing c"org.seidel.box.doesNothing", "Never blurs.";
    ClearsMessageInResolve c"org.seidel.box.clearsMessageInResolve", "Calls clearPersistentMessage where it is an invalid pointer.";
    WritesMaskOnly c"org.seidel.box.writesMaskOnly", "Writes nothing where the mask has no pixels.";
    ClearsMessageInDestroy c"org.seidel.box.clearsMessageInDestroy", "Calls clearPersistentMessage in DestroyInstance.";
    RequiresRegion c"org.seidel.box.requiresRegion", "Asks for nothing while the region of Source is unknown.";
    IgnoresBitDepth c"org.seidel.box.ignoresBitDepth", "Treats samples of any bit depth as floats.";
    TrustsRegion c"org.seidel.box.trustsRegion", "Crops Source to its region of definition, whatever the image covers.";
    OfBytes c"org.seidel.box.ofBytes", "None: the plugin is correct, and supports images of bytes alone.";
    UnwrittenAlpha c"org.seidel.box.unwrittenAlpha", "Of bytes: does not write the alpha of one pixel.";
    CoarseBytes c"org.seidel.box.coarseBytes", "Of bytes and floats: gives bytes in steps of eight.";
    WideBlurThreadDependent c"org.seidel.box.wideBlurThreadDependent", "Makes wide blurs depend on the number of threads.";
}

impl Fault {
    /// Returns whether the plugin supports images of bytes.
    pub(crate) fn takes_bytes(self) -> bool {
        matches!(
            self,
            Self::OfBytes | Self::UnwrittenAlpha | Self::CoarseBytes
        )
    }

    /// Returns whether the plugin supports images of floats.
    pub(crate) fn takes_floats(self) -> bool {
        !matches!(self, Self::OfBytes | Self::UnwrittenAlpha)
    }

    /// Returns the fault of the plugin with this index.
    pub(crate) fn of_plugin(index: usize) -> Self {
        ALL.get(index).copied().unwrap_or(Self::None)
    }
}
