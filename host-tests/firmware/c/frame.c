/* A frame rendered from C: the same program on bare metal and on the host. */
#include "slicecast.h"

#include "print.h"
#include "scene.h"

static uint64_t memory[(640 << 10) / 8];

static int check(int32_t code, const SlicecastError *error) {
  if (code >= 0) {
    return 1;
  }
  put("error code -");
  put_hex((uint32_t)-code);
  put(" needed ");
  put_hex((uint32_t)error->needed);
  put(" given ");
  put_hex((uint32_t)error->given);
  put("\n");
  return 0;
}

/* Slices are pushed whole, also to a scene that is cropped; it holds less of them. */
static size_t whole_slice(const SlicecastPipeline *pipeline, const SlicecastScene *scene, size_t bytes) {
  SlicecastScene all = *scene;
  SlicecastNeeds needs;
  int cropped = 0;
  for (int axis = 0; axis < 3; ++axis) {
    cropped |= all.crop_low[axis] != 0 || all.crop_high[axis] != 0;
    all.crop_low[axis] = 0;
    all.crop_high[axis] = 0;
  }
  if (slicecast_needs(pipeline, &all, 0, &needs, 0) < 0 || (cropped && bytes >= needs.bytes)) {
    return 0;
  }
  return needs.slice_voxels;
}

/* The voxels of a slice as colours and extinctions: entries made of their values, a row at a time. */
static const uint16_t *coloured(const uint16_t *slice, size_t width, size_t len, SlicecastError *error) {
  static uint16_t codes[4 * COLOUR_SLICE_VOXELS];
  static uint32_t entries[COLOUR_SLICE_VOXELS];
  if (len > COLOUR_SLICE_VOXELS) {
    return 0;
  }
  for (size_t i = 0; i < len; ++i) {
    const uint32_t byte = slice[i] >> 4;
    entries[i] = byte | (255 - byte) << 8 | (slice[i] * 5u & 255u) << 16 | byte << 24;
  }
  for (size_t i = 0; i < len; i += width) {
    if (!check(slicecast_codes(entries + i, 0, width, codes + 4 * i, error), error)) {
      return 0;
    }
  }
  return codes;
}

static int frame(const char *name, const SlicecastPipeline *pipeline, const SlicecastScene *scene, size_t planes,
                 uint32_t expected) {
  SlicecastError error;
  SlicecastNeeds needs;
  if (!check(slicecast_needs(pipeline, scene, 0, &needs, &error), &error)) {
    return 0;
  }
  SlicecastStream *stream;
  if (!check(slicecast_open(pipeline, scene, 0, 0, memory, sizeof memory, &stream, &error), &error)) {
    return 0;
  }
  static SlicecastClips made;
  if (planes > 0 && !check(slicecast_clip(stream, clips, planes, &cue, &made, &error), &error)) {
    return 0;
  }
  uint32_t number;
  const size_t len = whole_slice(pipeline, scene, needs.bytes);
  while (slicecast_wanted(stream, &number, &error) == SLICECAST_OK) {
    const uint16_t *slice = voxels + number * len;
    size_t count = len;
    if (scene->medium.exponent != 0) {
      slice = coloured(slice, needs.slice_width, len, &error);
      count = 4 * len;
    }
    if (slice == 0 || !check(slicecast_push(stream, slice, count, &error), &error)) {
      return 0;
    }
  }
  const void *image;
  size_t bytes;
  if (!check(slicecast_image(stream, &image, &bytes, &error), &error)) {
    return 0;
  }
  uint32_t sum = 0;
  for (size_t i = 0; i < bytes / needs.element_bytes; ++i) {
    sum = add(sum, needs.element_bytes == 2 ? ((const uint16_t *)image)[i] : ((const uint32_t *)image)[i]);
  }
  put("case ");
  put(name);
  put("\nimage ");
  put_hex(sum);
  put("\n");
  return sum == expected;
}

/* The scene with a table of 16-bit lanes, made of its own, and no other. */
static int fast_scene(SlicecastScene *fast) {
  static uint32_t roots[4096];
  static uint16_t colours[4 * 4097];
  static SlicecastFastTable table;
  SlicecastError error;
  *fast = scene;
  fast->low_colours = 0;
  if (!check(slicecast_fast_table(fast, roots, colours, &table, &error), &error)) {
    return 0;
  }
  fast->entries = 0;
  fast->low_roots = 0;
  fast->fast = &table;
  return 1;
}

int main(void) {
  SlicecastScene fast;
  int passed = slicecast_version() == SLICECAST_VERSION;
  passed &= frame("small compact unlit", slicecast_compact_unlit(), &scene, 0, COMPACT_UNLIT);
  passed &= frame("small compact lit", slicecast_compact_lit(), &scene, 0, COMPACT_LIT);
  passed &= frame("small wide lit", slicecast_wide_lit_colour16(), &scene_wide, 0, WIDE_LIT);
  passed &= frame("small compact lit cropped", slicecast_compact_lit(), &scene_cropped, 0, CROPPED);
  passed &= frame("small compact lit clipped", slicecast_compact_lit(), &scene, sizeof clips / sizeof *clips, CLIPPED);
  passed &= frame("small compact unlit colours", slicecast_compact_unlit_rgba(), &scene_colours, 0, COLOURS_COMPACT_UNLIT);
  passed &= frame("small wide lit colours", slicecast_wide_lit_rgba(), &scene_colours, 0, COLOURS_WIDE_LIT);
  passed &= fast_scene(&fast);
  passed &= frame("small fast unlit", slicecast_fast_unlit(), &fast, 0, FAST_UNLIT);
  passed &= frame("small fast lit", slicecast_fast_lit(), &fast, 0, FAST_LIT);
  /* What C gets wrong comes back as a number. */
  SlicecastError error;
  passed &= slicecast_push((SlicecastStream *)memory, voxels, 1, &error) == SLICECAST_COMPLETE;
  passed &= slicecast_wanted(0, 0, &error) == SLICECAST_NULL && error.argument == 1;
  put(passed ? "verdict pass\n" : "verdict fail\n");
  return verdict(passed);
}
