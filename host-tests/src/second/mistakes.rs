//! Mistakes that an implementation may make and that pictures hardly show: each is a reading of the contract that does not
//! hold. The second model makes one at a time, and the directed vectors have to find it.

/// Declares the list once: a name for the code, the stage, and the mistake in words.
macro_rules! mistakes {
    ($($name:ident, $stage:literal, $words:literal;)*) => {
        /// A mistake.
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum Mistake {
            $(#[doc = $words] $name,)*
        }

        impl Mistake {
            /// All mistakes, in the order of the stages.
            pub const ALL: &'static [Self] = &[$(Self::$name,)*];

            /// The stage that makes it.
            pub const fn stage(self) -> &'static str {
                match self {
                    $(Self::$name => $stage,)*
                }
            }

            /// What is wrong.
            pub const fn words(self) -> &'static str {
                match self {
                    $(Self::$name => $words,)*
                }
            }
        }
    };
}

mistakes! {
    StepTruncated, "location", "steps truncated";
    StepHalvesUp, "location", "halves of a negative step up instead of away from zero";
    TiesToX, "location", "equal components go to x before y before z";
    BaseOfExactStep, "location", "base plane from the exact step instead of the coded one";
    OriginOnOtherSide, "location", "origin at -n where the step is negative";
    StartTruncated, "location", "a phase's start truncated";
    PositionTruncated, "location", "positions truncated";
    PositionHalvesDown, "location", "halves of a position down";
    StepOf16Bits, "location", "a step of 16 fraction bits";
    NearestHalvesDown, "location", "the nearest voxel of a half is the lower one";
    ExistsBy12Bits, "location", "whether a sample exists by 12 bits of its weight";
    LastVoxelLeftOut, "location", "no sample on the last voxel";
    DitherWithoutStart, "location", "colour offsets begin at 0 instead of 9973";
    BaseOfNodes, "borders", "the base plane of cells from the outermost voxels";
    BaseOfFirstPhase, "borders", "the base plane by the first phase alone";
    FrontEnd, "borders", "a sample at the front end of its segment";
    MiddleTruncated, "borders", "the middle truncated";
    Unheld, "borders", "samples behind the last voxel left there";
    FaceOpen, "borders", "nothing of a segment that runs along a face";
    FacesExchanged, "borders", "the faces of a falling segment exchanged";
    ShareTruncated, "borders", "shares truncated";
    FractionLinear, "borders", "the opacity times the fraction";
    FractionTruncated, "borders", "the depth of a fraction truncated";
    FractionUnheld, "borders", "the opacity of a fraction above the whole one";
    OpaqueThinned, "borders", "an opaque sample thinned";
    DepthTruncated, "borders", "the logarithm truncated";
    WeightUncut, "interpolation", "all 16 bits of a weight in paper";
    YTruncated, "interpolation", "the y step truncated";
    YTowardsZero, "interpolation", "the y product truncated towards zero";
    YUncut, "interpolation", "16 bits kept after y in paper";
    XTruncated, "interpolation", "the sample truncated";
    XRoundedTwice, "interpolation", "the x product rounded before the sample is";
    XTowardsZero, "interpolation", "the x product truncated towards zero";
    XRoundedInPaper, "interpolation", "the sample rounded in paper";
    XBeforeY, "interpolation", "x before y";
    RootsMixed, "classification", "roots mixed, then squared";
    OpacityTruncated, "classification", "the square halved without rounding";
    ByteTimes256, "classification", "a root of 8 bits times 256";
    LowRootLeftOut, "classification", "the root's low byte left out";
    ColourTruncated, "classification", "colours halved without rounding";
    WideColourOf15Bits, "classification", "1.31 colours made of 1.15 ones";
    BlueFirst, "classification", "blue in the lowest byte";
    LowBlueFirst, "classification", "blue first among the low bytes";
    NearestTruncated, "classification", "the entry below instead of the nearest";
    LinearTruncated, "classification", "a mixture truncated";
    LinearTowardsZero, "classification", "a falling mixture rounded towards zero";
    NextIndexed, "classification", "the fraction of the next entry";
    SpacingTruncated, "gradient", "the spacing product truncated";
    SpacingHalvesAway, "gradient", "halves of the spacing product away from zero";
    SpacingBeforeDifference, "gradient", "samples times the factor, then the difference";
    BlockTruncated, "normalisation", "components of g truncated";
    BlockHalvesUp, "normalisation", "halves of g up instead of on magnitudes";
    BlockUnsaturated, "normalisation", "g reaches 32768";
    BlockOf32Bits, "normalisation", "-2^31 counts 32 bits";
    BlockEach, "normalisation", "each component brought to 15 bits by itself";
    RootNearest, "normalisation", "r to the nearest";
    RootInF64, "normalisation", "r from a double: (uint64)(2^35 / sqrt(S))";
    RootOfNothing, "normalisation", "r at its largest where S = 0";
    ExportTruncated, "normalisation", "the normal for export truncated";
    ExportHalvesUp, "normalisation", "halves of that normal up instead of on magnitudes";
    ExportReversed, "normalisation", "that normal towards lower values";
    VectorPlain, "shading", "vectors plainly rounded to 15 bits";
    VectorTieToLast, "shading", "of equal lattice vectors the last";
    VectorByLengthAlone, "shading", "of lattice vectors of one length the first, not the nearest";
    CoefficientTruncated, "shading", "coefficients truncated";
    NormalTowards, "shading", "the normal towards higher values";
    NormalFloor, "shading", "paper's normal towards minus infinity";
    CosineTruncated, "shading", "cosines truncated";
    CosineFirstShift, "shading", "wide's dot product truncated before r";
    CosineUnheld, "shading", "cosines above 1 left so";
    ProductsSummedFirst, "shading", "paper's three products summed, then truncated";
    ReflectionTruncated, "shading", "the reflection's product truncated";
    ReflectionUnheld, "shading", "reflections above 1 left so";
    ReflectionUnguarded, "shading", "a reflection where a cosine is 0";
    ViewerLightRounded, "shading", "V.L rounded instead of truncated";
    PowerTruncated, "shading", "squarings truncated";
    PowerOf16Bits, "shading", "squarings in 16 bits";
    CosineCut, "shading", "cosines cut to 16 bits in front of their coefficients";
    DiffuseUnheld, "shading", "diffuse light above 1 left so";
    DiffuseTruncated, "shading", "compact's sum of light truncated";
    ColourTruncatedLast, "shading", "the colour truncated";
    ColourUnheld, "shading", "colours above 1 left so";
    SumWraps, "shading", "a sum of light wraps at 32 bits";
    ProductsRounded, "shading", "products with coefficients rounded instead of truncated";
    HighlightColoured, "shading", "highlights in the sample's colour";
    HighlightInShadow, "shading", "a half vector's highlight where N.L is 0";
    HalvedApart, "shading", "paper's two parts halved before they are summed";
    TransparencyHalfUnit, "compositing", "2 dT in place of 2 dT + 1";
    ColourHalfUnit, "compositing", "2 dC in place of 2 dC + 1, back to front";
    DithersExchanged, "compositing", "dC for T and dT for C";
    ColourUndithered, "compositing", "no offset for C";
    ColourAfter, "compositing", "C takes the light that is left, not what the sample took";
    TakenRounded, "compositing", "the light taken rounded to nearest";
    OpacityOf16Bits, "compositing", "compact reads an opacity of 1.16";
    OpacityUncut, "compositing", "paper's transparency of a step from all 31 bits";
    PaperOrder, "compositing", "paper multiplies colour and transparency first";
    ScaledTruncated, "compositing", "C' truncated";
    ScaledTwice, "compositing", "C' = 2 c";
    BackInOneProduct, "compositing", "wide's two products back to front as one";
    FloorIncluded, "compositing", "T at the floor becomes 0";
    FloorLeftOut, "compositing", "no floor";
    KeptUnsigned, "projection", "kept samples compared without their sign";
    EmptyMaximumSeen, "projection", "an empty ray of a maximum classified";
    EmptyMinimumSeen, "projection", "an empty ray of a minimum classified";
    ResolvedWithoutHalf, "projection", "a dither of 0 taken for no half unit";
    CoordinateTruncated, "warp", "coordinates truncated";
    CoordinateOf16Bits, "warp", "steps of 16 fraction bits";
    MixTruncated, "warp", "mixtures truncated";
    MixTowardsZero, "warp", "falling mixtures rounded towards zero";
    MixDownFirst, "warp", "along v, then along u";
    BackgroundTruncated, "warp", "the background's product truncated";
    SumUnheld, "warp", "a sum above 1 left so";
    ByteTruncated, "warp", "bytes truncated";
    ByteTopBits, "warp", "the top 8 bits for a byte";
}
