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
    if (!check(slicecast_push(stream, voxels + number * len, len, &error), &error)) {
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

int main(void) {
  int passed = slicecast_version() == SLICECAST_VERSION;
  passed &= frame("small compact unlit", slicecast_compact_unlit(), &scene, 0, COMPACT_UNLIT);
  passed &= frame("small compact lit", slicecast_compact_lit(), &scene, 0, COMPACT_LIT);
  passed &= frame("small wide lit", slicecast_wide_lit_colour16(), &scene_wide, 0, WIDE_LIT);
  passed &= frame("small compact lit cropped", slicecast_compact_lit(), &scene_cropped, 0, CROPPED);
  passed &= frame("small compact lit clipped", slicecast_compact_lit(), &scene, sizeof clips / sizeof *clips, CLIPPED);
  /* What C gets wrong comes back as a number. */
  SlicecastError error;
  passed &= slicecast_push((SlicecastStream *)memory, voxels, 1, &error) == SLICECAST_COMPLETE;
  passed &= slicecast_wanted(0, 0, &error) == SLICECAST_NULL && error.argument == 1;
  put(passed ? "verdict pass\n" : "verdict fail\n");
  return verdict(passed);
}
