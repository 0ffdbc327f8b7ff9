/* Seidel's C ABI: real lens blur, learned from measured point-spread functions.
 *
 * Generated from plugin/src by `cargo xtask header`; do not edit.
 *
 * Every call returns a SeidelStatus; seidel_last_error describes the last failure on the calling thread. All functions
 * may be called from any number of threads at once. Structs begin with their size, which the caller sets, so that later
 * versions can add members. Buffers belong to the caller, and the library keeps no pointer to them after a call. No
 * panic leaves the library, and it prints nothing but Rust's own panic message on stderr. */

#ifndef SEIDEL_H
#define SEIDEL_H

#include <stddef.h>
#include <stdint.h>

/**
 * Samples of 16 bits: IEEE 754 half.
 */
#define SEIDEL_HALF 1

/**
 * Samples of 32 bits: IEEE 754 single.
 */
#define SEIDEL_FLOAT 2

/**
 * The lens is described by moments of its PSFs.
 */
#define SEIDEL_LENS_MOMENTS 0

/**
 * The lens is known ray by ray: its controls can be set.
 */
#define SEIDEL_LENS_RAYS 1

/**
 * Blur alone.
 */
#define SEIDEL_GEOMETRY_NONE 0

/**
 * Channels displaced against each other, the plate undistorted. The default.
 */
#define SEIDEL_GEOMETRY_LATERAL 1

/**
 * Distortion and lateral colour.
 */
#define SEIDEL_GEOMETRY_FULL 2

/**
 * Beyond the plate lies the mirrored plate: no light is lost. The default.
 */
#define SEIDEL_EDGES_MIRROR 0

/**
 * Beyond the plate lies nothing.
 */
#define SEIDEL_EDGES_BLACK 1

/**
 * Beyond the plate lies its nearest pixel, with its depth and blur.
 */
#define SEIDEL_EDGES_NEAREST 2

/**
 * For looking: 45 dB from exact.
 */
#define SEIDEL_QUALITY_DRAFT 0

/**
 * For delivery: 60 dB from exact; 50 dB for lenses drawn ray by ray. The default.
 */
#define SEIDEL_QUALITY_FINAL 1

/**
 * Every source pixel with its own kernel: slow.
 */
#define SEIDEL_QUALITY_EXACT 2

/**
 * Colour is multiplied by alpha. The default.
 */
#define SEIDEL_ALPHA_PREMULTIPLIED 0

/**
 * Colour is not multiplied by alpha.
 */
#define SEIDEL_ALPHA_UNPREMULTIPLIED 1

/**
 * Depth is distance along the optical axis, in `depth_unit` metres. The default.
 */
#define SEIDEL_DEPTH_DISTANCE 0

/**
 * Depth is one over the distance in such units; 0 is infinity.
 */
#define SEIDEL_DEPTH_INVERSE 1

/**
 * Depth is 0 at `depth_near` and 1 at `depth_far`, distance linear between.
 */
#define SEIDEL_DEPTH_FAR_ONE 2

/**
 * Depth is 1 at `depth_near` and 0 at `depth_far`, distance linear between.
 */
#define SEIDEL_DEPTH_FAR_ZERO 3

/**
 * Where the plate is clipped is told from it. The default.
 */
#define SEIDEL_CLIP_TOLD 0

/**
 * No sample is clipped.
 */
#define SEIDEL_CLIP_NONE 1

/**
 * Samples of `clip_level` and more are clipped.
 */
#define SEIDEL_CLIP_LEVEL 2

/**
 * The sharp picture gets the plate's own grain. The default.
 */
#define SEIDEL_GRAIN_KEEP 0

/**
 * The sharp picture as it was solved for, nearly without grain.
 */
#define SEIDEL_GRAIN_SOLVED 1

/**
 * Version of the ABI that this header describes. It grows when calls or structs are added, which old callers need not
 * know of; libraries of another one may lack what this header has.
 */
#define SEIDEL_ABI_VERSION 1

/**
 * What became of a call. `seidel_last_error` says why in words.
 */
typedef enum SeidelStatus {
  /**
   * All went well.
   */
  SEIDEL_STATUS_OK = 0,
  /**
   * A null pointer, a size or value that cannot be, a handle that is none, or a sample that is not finite.
   */
  SEIDEL_STATUS_ARGUMENT = 1,
  /**
   * A lens profile that cannot be read, or is none.
   */
  SEIDEL_STATUS_LENS = 2,
  /**
   * What was asked for cannot be done with this lens, or by this version.
   */
  SEIDEL_STATUS_UNSUPPORTED = 3,
  /**
   * Memory ran out, or more would be needed than the settings allow.
   */
  SEIDEL_STATUS_MEMORY = 4,
  /**
   * The progress callback said to stop. Outputs are untouched.
   */
  SEIDEL_STATUS_ABORTED = 5,
  /**
   * A fault of this library. The handle and the process can go on being used.
   */
  SEIDEL_STATUS_PANICKED = 6,
  /**
   * The buffer is too small; how large it must be was stored.
   */
  SEIDEL_STATUS_TOO_SMALL = 7,
} SeidelStatus;

/**
 * A lens. Any number of threads may use it at once.
 */
typedef struct SeidelLens SeidelLens;

/**
 * How a lens is used and a plate is read. Begin with `seidel_settings_init`. Numbers that say "NaN: ..." may be left
 * NaN. Switches are 0 or 1. The same names are options of the `seidel` command.
 */
typedef struct SeidelSettings {
  /**
   * sizeof(SeidelSettings).
   */
  uint64_t size;
  /**
   * How strong blur and displacement are: 0 leaves the plate as it is, 1 is as measured, 16 is the most.
   */
  double amount;
  /**
   * How strong the blur of each channel of the lens is besides, in their order; NULL: all 1.
   */
  const double *channel_scales;
  /**
   * How many there are: as many as channels, or 0.
   */
  uint32_t channel_scale_count;
  /**
   * SEIDEL_GEOMETRY_...
   */
  uint32_t geometry;
  /**
   * Where the optical axis lies, in plate pixels right of where it would.
   */
  double axis_offset_x;
  /**
   * The same, below.
   */
  double axis_offset_y;
  /**
   * PSF model by its name; NULL or "": what suits the lens best.
   */
  const char *psf_model;
  /**
   * Focus the lens at this distance, metres, or INFINITY. NaN: as measured.
   */
  double focus_distance;
  /**
   * Stop the lens down to this f-number. NaN: as measured.
   */
  double f_number;
  /**
   * Move the sensor away from the lens, micrometres. NaN: as measured.
   */
  double sensor_shift_um;
  /**
   * Metres about the focus plane in which all is as sharp as on it.
   */
  double depth_of_field;
  /**
   * How many times as far from focus, in vergence, things before the focus plane are.
   */
  double front_multiplier;
  /**
   * The same behind it.
   */
  double back_multiplier;
  /**
   * Largest kernel: the radius of an even disc, plate pixels. NaN: none.
   */
  double maximum_size;
  /**
   * SEIDEL_QUALITY_...
   */
  uint32_t quality;
  /**
   * SEIDEL_EDGES_...
   */
  uint32_t edges;
  /**
   * Switch: near things hide far ones where depth varies.
   */
  uint32_t occlusion;
  /**
   * Switch: what a blurred foreground uncovers is filled with what is seen beside it.
   */
  uint32_t fill_foreground;
  /**
   * Switch: a blurred foreground becomes transparent within its own outline.
   */
  uint32_t blur_inside;
  /**
   * SEIDEL_ALPHA_...
   */
  uint32_t alpha;
  /**
   * Switch: the alpha of each colour is blurred as its colour, and written to `alphas`.
   */
  uint32_t alpha_per_channel;
  /**
   * Switch: samples that are not finite count as zero, instead of being refused.
   */
  uint32_t scrub;
  /**
   * Plate pixels per pixel of the lens's frame, counted along y. NaN: the format is as wide as the frame.
   */
  double lens_scale;
  /**
   * Width of a plate pixel over its height.
   */
  double pixel_aspect;
  /**
   * The one distance of plates without a depth image, metres, or INFINITY. NaN: not known.
   */
  double distance;
  /**
   * Metres that make up one unit of depth; negative if it counts backwards.
   */
  double depth_unit;
  /**
   * Nearest distance of a normalised depth, metres.
   */
  double depth_near;
  /**
   * Farthest distance of a normalised depth, metres.
   */
  double depth_far;
  /**
   * Focal length in widths of a plate pixel, where distances are along the ray from the camera. NaN: along the axis.
   */
  double along_ray;
  /**
   * SEIDEL_DEPTH_...
   */
  uint32_t depth_kind;
  /**
   * SEIDEL_CLIP_... (taking blur off)
   */
  uint32_t clip;
  /**
   * Where samples are clipped. (taking blur off)
   */
  double clip_level;
  /**
   * Standard deviation of the noise of each colour; NaN in the first: estimated from the plate, in others: as the first.
   * (taking blur off)
   */
  double noise[4];
  /**
   * How much of the way from the plate to the sharp picture to go, 0 to 1. (seidel_remove)
   */
  double strength;
  /**
   * SEIDEL_GRAIN_... (seidel_remove)
   */
  uint32_t grain;
  /**
   * Most threads to work with; 0: as many as the machine has. No result depends on it.
   */
  uint32_t threads;
  /**
   * Most memory that a call may need, bytes, by `seidel_memory_needed`; 0: any.
   */
  uint64_t memory;
} SeidelSettings;

/**
 * A rectangle of a plate's pixels: x to the right, y down.
 */
typedef struct SeidelRect {
  /**
   * Its first column.
   */
  int32_t left;
  /**
   * Its first row.
   */
  int32_t top;
  /**
   * Columns.
   */
  int32_t width;
  /**
   * Rows.
   */
  int32_t height;
} SeidelRect;

/**
 * A picture in the caller's memory, read or written in place. It may lie at any address, with any room between pixels and
 * rows; nothing but its samples is touched.
 */
typedef struct SeidelImage {
  /**
   * sizeof(SeidelImage).
   */
  uint64_t size;
  /**
   * The first sample of the pixel at (rect.left, rect.top).
   */
  void *data;
  /**
   * Bytes from a pixel to the one below it; negative where rows are stored from the bottom up.
   */
  int64_t row_bytes;
  /**
   * Bytes from a pixel to the one on its right; 0 where nothing lies between them. With it and `data` one channel of
   * many can be given alone.
   */
  uint32_t pixel_bytes;
  /**
   * Samples of a pixel that count, 1 to 4. Of plates: 1 is Y, 2 are Y and A, 3 are R, G and B, 4 are R, G, B and A.
   */
  uint32_t channels;
  /**
   * SEIDEL_HALF or SEIDEL_FLOAT.
   */
  uint32_t sample;
  /**
   * Leave it 0.
   */
  uint32_t reserved;
  /**
   * Which pixels of the plate it holds.
   */
  struct SeidelRect rect;
} SeidelImage;

/**
 * A plate. Pictures may hold a part of it, or more than it: what of the plate they lack counts as black, of depth and
 * mattes as the nearest pixel that there is.
 */
typedef struct SeidelPlate {
  /**
   * sizeof(SeidelPlate).
   */
  uint64_t size;
  /**
   * The picture proper: what the lens's frame is laid on, centre on centre.
   */
  struct SeidelRect format;
  /**
   * All pixels that there are, with overscan: beyond them lies what `edges` says. No result for a part of it depends on
   * how much of it is handed in, as long as that covers the region of interest.
   */
  struct SeidelRect extent;
  /**
   * Its samples: linear light.
   */
  const struct SeidelImage *source;
  /**
   * Depth: the first channel counts. NULL: all is at the settings' `distance`.
   */
  const struct SeidelImage *depth;
  /**
   * Matte, 0 to 1, of something that will be in front: the first channel counts. May be NULL. (seidel_apply)
   */
  const struct SeidelImage *matte;
  /**
   * Depth of the matte, read as `depth` is: only what is behind is kept back. May be NULL. (seidel_apply)
   */
  const struct SeidelImage *matte_depth;
  /**
   * Alpha of each colour, where settings say `alpha_per_channel`: one channel a colour. NULL: they are as A.
   */
  const struct SeidelImage *alphas;
} SeidelPlate;

/**
 * Called with `user` and the share done, 0 to 1, about fifty times a second, always on the thread that called the
 * library. Whatever is not 0 stops the work. It must return, not throw or jump.
 */
typedef int32_t (*SeidelProgress)(void *user, double share);

/**
 * What is called back while a call works.
 */
typedef struct SeidelCallbacks {
  /**
   * sizeof(SeidelCallbacks).
   */
  uint64_t size;
  /**
   * Handed back as it is.
   */
  void *user;
  /**
   * May be NULL.
   */
  SeidelProgress progress;
} SeidelCallbacks;

/**
 * A kernel: where the light of one source pixel lands. Set `size`, `weights` and `capacity`; the rest is written.
 */
typedef struct SeidelKernel {
  /**
   * sizeof(SeidelKernel).
   */
  uint64_t size;
  /**
   * Gets the weights, row by row; they sum to one. May be NULL to learn how many there are.
   */
  float *weights;
  /**
   * How many weights there is room for.
   */
  uint64_t capacity;
  /**
   * Column of the first weight, from the source pixel.
   */
  int32_t left;
  /**
   * Row of the first weight, from the source pixel.
   */
  int32_t top;
  /**
   * Columns.
   */
  uint32_t width;
  /**
   * Rows.
   */
  uint32_t height;
} SeidelKernel;

/**
 * What is known of a lens. Numbers that are not known are NaN.
 */
typedef struct SeidelLensInfo {
  /**
   * sizeof(SeidelLensInfo); set it before asking.
   */
  uint64_t size;
  /**
   * SEIDEL_LENS_...
   */
  uint32_t kind;
  /**
   * Colour channels: see seidel_lens_channel.
   */
  uint32_t channels;
  /**
   * PSF models that can draw it: see seidel_lens_model.
   */
  uint32_t models;
  /**
   * Whether its blur depends on distance.
   */
  uint32_t knows_depth;
  /**
   * Columns of its frame.
   */
  uint32_t frame_width;
  /**
   * Rows of its frame.
   */
  uint32_t frame_height;
  /**
   * Where its optical axis meets the frame, pixels right of the frame's left edge.
   */
  double axis_x;
  /**
   * The same, below its top edge.
   */
  double axis_y;
  /**
   * Pixel pitch, micrometres.
   */
  double pixel_pitch_um;
  /**
   * Focal length, millimetres.
   */
  double focal_length_mm;
  /**
   * F-number at which it was measured.
   */
  double f_number;
  /**
   * Distance at which it was focused, metres; may be INFINITY.
   */
  double focus_distance;
  /**
   * Nearest distance at which it was measured, metres.
   */
  double nearest;
  /**
   * Farthest distance at which it was measured, metres; may be INFINITY.
   */
  double farthest;
} SeidelLensInfo;

/**
 * What seidel_remove tells beside the picture. Set `size` and the two pictures before the call; the rest is written.
 */
typedef struct SeidelFindings {
  /**
   * sizeof(SeidelFindings).
   */
  uint64_t size;
  /**
   * Gets how much of each pixel was seen and not guessed, 0 to 1, a channel a colour. May be NULL.
   */
  const struct SeidelImage *confidence;
  /**
   * Gets how many times its size in the plate noise has in the sharp picture, a channel a colour. May be NULL; takes as
   * long again.
   */
  const struct SeidelImage *noise_gain;
  /**
   * All pixels that were found: the plate's extent and what is about it.
   */
  struct SeidelRect found;
  /**
   * Standard deviation of the noise of each colour, as given or as estimated from the plate.
   */
  double noise[3];
  /**
   * What the lens leaves unexplained of each colour, in times of what noise lets expect: well above 1.5, it is not the
   * lens of the plate.
   */
  double misfit[3];
  /**
   * From where on samples of each colour are clipped; NaN where none are.
   */
  double clip_level[3];
  /**
   * How many are.
   */
  uint64_t clipped[3];
} SeidelFindings;

#ifdef __cplusplus
extern "C" {
#endif // __cplusplus

/**
 * Puts the blur of a lens on the pixels that `output.rect` names of a plate; it must lie in the plate's extent. `output`
 * may be the memory of the source. Where the source covers what seidel_region_of_interest names, the result is that part
 * of the whole plate's, to the bit. `settings` may be NULL for the defaults, `callbacks` NULL for none. `alphas` gets the
 * alpha of each colour where settings say `alpha_per_channel`; NULL otherwise.
 *
 * Pointers:
 * All pointers must be NULL or good until the call ends; outputs must not be used by other threads meanwhile.
 */
enum SeidelStatus seidel_apply(const struct SeidelLens *lens,
                               const struct SeidelSettings *settings,
                               const struct SeidelPlate *plate,
                               const struct SeidelImage *output,
                               const struct SeidelImage *alphas,
                               const struct SeidelCallbacks *callbacks);

/**
 * Draws the kernel of a channel of a lens at (`x`, `y`), plate pixels right of and below the corner of the pixel (0, 0),
 * for an object `distance` metres away, or INFINITY; NaN for a lens that does not ask. Of the plate, `format` and
 * `extent` count. SEIDEL_STATUS_TOO_SMALL where there is no room for all weights: `width` and `height` tell how many.
 *
 * Pointers:
 * All pointers must be NULL or good until the call ends, `kernel->weights` for `kernel->capacity` numbers.
 */
enum SeidelStatus seidel_kernel(const struct SeidelLens *lens,
                                const struct SeidelSettings *settings,
                                const struct SeidelPlate *plate,
                                uint32_t channel,
                                double x,
                                double y,
                                double distance,
                                struct SeidelKernel *kernel);

/**
 * Copies why the last call on this thread failed, in UTF-8 with a zero at its end, cut to `capacity` bytes. Returns the
 * bytes that the whole text takes with its zero; 1, an empty text, after a call that went well. `buffer` may be NULL if
 * `capacity` is 0.
 *
 * Pointers:
 * `buffer` must point to `capacity` bytes that can be written.
 */
size_t seidel_last_error(char *buffer,
                         size_t capacity);

/**
 * Opens the lens profile in the file at `path`, in UTF-8. Release `*lens` when it is no longer needed.
 *
 * Pointers:
 * `path` must point to a text with a zero at its end, `lens` to a place for a handle.
 */
enum SeidelStatus seidel_lens_open(const char *path, struct SeidelLens **lens);

/**
 * The same of the `length` bytes of a profile's JSON text in memory.
 *
 * Pointers:
 * `json` must point to `length` bytes, `lens` to a place for a handle.
 */
enum SeidelStatus seidel_lens_read(const char *json, size_t length, struct SeidelLens **lens);

/**
 * Holds a lens once more: it must be released once more.
 */
enum SeidelStatus seidel_lens_retain(const struct SeidelLens *lens);

/**
 * Lets go of a lens; NULL is let go of too. Calls that use it go on. With the last lens the threads of the library end,
 * after the work that they do.
 */
enum SeidelStatus seidel_lens_release(const struct SeidelLens *lens);

/**
 * Tells what is known of a lens. `info->size` must have been set.
 *
 * Pointers:
 * `info` must point to as many bytes as its size says, which can be written.
 */
enum SeidelStatus seidel_lens_info(const struct SeidelLens *lens, struct SeidelLensInfo *info);

/**
 * Copies the name of a channel, such as "R", in UTF-8 with a zero at its end; `*needed`, unless NULL, is told how many
 * bytes it takes. SEIDEL_STATUS_TOO_SMALL if that is more than `capacity`; then it is cut.
 *
 * Pointers:
 * `buffer` must point to `capacity` bytes, `needed` be NULL or a place for a number.
 */
enum SeidelStatus seidel_lens_channel(const struct SeidelLens *lens,
                                      uint32_t index,
                                      char *buffer,
                                      size_t capacity,
                                      size_t *needed);

/**
 * The same of the name of a PSF model that can draw the lens; the first is what suits it best.
 *
 * Pointers:
 * That of seidel_lens_channel.
 */
enum SeidelStatus seidel_lens_model(const struct SeidelLens *lens,
                                    uint32_t index,
                                    char *buffer,
                                    size_t capacity,
                                    size_t *needed);

/**
 * Compares the blur that a plate shows with that of the lens it is said to be taken with: `blur_share` gets the plate's as
 * a share of the lens's, 1 where nothing speaks against the lens. What `seidel remove` does with it: below 1, settings.amount
 * is multiplied by it, since to remove more would ring; above 1, it is said. settings.amount must not be 0. `settings` and
 * `callbacks` may be NULL as in seidel_apply.
 *
 * Pointers:
 * That of seidel_apply; `blur_share` must be good for a number.
 */
enum SeidelStatus seidel_check_lens(const struct SeidelLens *lens,
                                    const struct SeidelSettings *settings,
                                    const struct SeidelPlate *plate,
                                    double *blur_share,
                                    const struct SeidelCallbacks *callbacks);

/**
 * Tells which pixels of the source seidel_apply must be given for its result in `window` to be that part of the whole
 * plate's to the bit. Of the plate, `format`, `extent` and whether there is a depth count. With SEIDEL_QUALITY_EXACT, one
 * distance and a model that needs no rays this is `window` and as much about it as kernels reach; otherwise the whole
 * extent: the fast renderer chooses its ways by all of the plate. seidel_remove and seidel_relens always need it all.
 *
 * Pointers:
 * All pointers must be NULL or good until the call ends.
 */
enum SeidelStatus seidel_region_of_interest(const struct SeidelLens *lens,
                                            const struct SeidelSettings *settings,
                                            const struct SeidelPlate *plate,
                                            const struct SeidelRect *window,
                                            struct SeidelRect *region);

/**
 * Tells how much memory seidel_apply (`removal` 0), or seidel_remove and seidel_relens (1) take at most for a plate, beside
 * the caller's own pictures, bytes. Of the plate, `extent` counts, and the channels of its source.
 *
 * Pointers:
 * All pointers must be NULL or good until the call ends.
 */
enum SeidelStatus seidel_memory_needed(const struct SeidelSettings *settings,
                                       const struct SeidelPlate *plate,
                                       uint32_t removal,
                                       uint64_t *bytes);

/**
 * Takes the blur of the lens `from` off a plate and puts that of `to` on; the plate keeps its grain. Settings hold for
 * both lenses. All else is as in seidel_remove, but that `output.rect` must lie in the extent.
 *
 * Pointers:
 * That of seidel_apply.
 */
enum SeidelStatus seidel_relens(const struct SeidelLens *from,
                                const struct SeidelLens *to,
                                const struct SeidelSettings *settings,
                                const struct SeidelPlate *plate,
                                const struct SeidelImage *output,
                                const struct SeidelImage *alphas,
                                const struct SeidelCallbacks *callbacks);

/**
 * Takes the blur of the lens that a plate was taken with off it. The source must cover the extent: what it lacks counts as
 * black. `output.rect` may go beyond the extent, where light was found that lands on the plate; what lies beyond
 * `findings.found` is black. Depth is that of the sharp picture. `findings`, `settings`, `alphas` and `callbacks` may be
 * NULL as in seidel_apply.
 *
 * Pointers:
 * That of seidel_apply.
 */
enum SeidelStatus seidel_remove(const struct SeidelLens *lens,
                                const struct SeidelSettings *settings,
                                const struct SeidelPlate *plate,
                                const struct SeidelImage *output,
                                const struct SeidelImage *alphas,
                                struct SeidelFindings *findings,
                                const struct SeidelCallbacks *callbacks);

/**
 * Puts the defaults into `settings`, whose `size` must have been set to sizeof(SeidelSettings).
 *
 * Pointers:
 * `settings` must point to as many bytes as its `size` says, which can be written.
 */
enum SeidelStatus seidel_settings_init(struct SeidelSettings *settings);

/**
 * Ends all threads of the library, after the work that they do. Call it before the library is unloaded; it is done by
 * itself when the last lens is released. The library can go on being used: threads are started again when there is work.
 */
enum SeidelStatus seidel_shutdown(void);

/**
 * Version of the ABI that the library speaks: at least SEIDEL_ABI_VERSION for all of this header to be there.
 */
uint32_t seidel_abi_version(void);

/**
 * The library's own version, such as "0.1.0"; the text stays as long as the library is loaded.
 */
const char *seidel_version(void);

#ifdef __cplusplus
}  // extern "C"
#endif  // __cplusplus

#endif  /* SEIDEL_H */
