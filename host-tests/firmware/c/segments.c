/* Segments from C, on bare metal and on the host: an exported scene, the table that `slicecast table` writes, and a view that
   turns without another table. */
#include "head.h"
#include "head_voxels.h"
/* Behind slicecast.h: it has a SlicecastIntegrals then. */
#include "bone.h"

#include "expected.h"
#include "print.h"

static uint64_t memory[(640 << 10) / 8];

static int frame(const char *name, const SlicecastPipeline *pipeline, const SlicecastScene *scene, uint32_t expected) {
  SlicecastError error;
  SlicecastStream *stream;
  int32_t code = slicecast_open(pipeline, scene, 0, 0, memory, sizeof memory, &stream, &error);
  uint32_t number;
  while (code >= 0 && slicecast_wanted(stream, &number, &error) == SLICECAST_OK) {
    code = slicecast_push(stream, head_voxels + number * HEAD_SLICE_VOXELS, HEAD_SLICE_VOXELS, &error);
  }
  SlicecastNeeds needs;
  const void *image;
  size_t bytes;
  if (code < 0 || (code = slicecast_needs(pipeline, scene, 0, &needs, &error)) < 0 ||
      (code = slicecast_image(stream, &image, &bytes, &error)) < 0) {
    put("error code -");
    put_hex((uint32_t)-code);
    put("\n");
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
  static const int64_t turned_direction[3] = TURNED_DIRECTION;
  SlicecastScene scene = head;
  scene.integrals = &bone_integrals;
  /* Nothing of the table for points is left. */
  scene.entries = 0;
  scene.low_roots = 0;
  scene.low_colours = 0;
  SlicecastScene turned = scene;
  for (int axis = 0; axis < 3; ++axis) {
    turned.direction[axis] = turned_direction[axis];
  }
  int passed = frame("paper unlit", slicecast_paper_unlit_segments(), &scene, PAPER_UNLIT);
  passed &= frame("paper lit", slicecast_paper_lit_segments(), &scene, PAPER_LIT);
  passed &= frame("compact unlit", slicecast_compact_unlit_segments(), &scene, COMPACT_UNLIT);
  passed &= frame("compact lit", slicecast_compact_lit_segments(), &scene, COMPACT_LIT);
  passed &= frame("wide unlit", slicecast_wide_unlit_segments(), &scene, WIDE_UNLIT);
  passed &= frame("wide lit", slicecast_wide_lit_segments(), &scene, WIDE_LIT);
  passed &= frame("turned", slicecast_compact_unlit_segments(), &turned, TURNED);
  put(passed ? "verdict pass\n" : "verdict fail\n");
  return verdict(passed);
}
