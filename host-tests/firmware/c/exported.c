/* The built-in head from headers that `slicecast export` writes, and slicecast.h: scene, table, voxels. */
#include "head.h"
#include "head_voxels.h"

#include "print.h"
#include "sums.h"

/* The compiler has counted it. */
static uint64_t memory[HEAD_BYTES / 8];

static uint8_t row[3 * HEAD_COLUMNS];

static int32_t frame(uint32_t *image_sum, uint32_t *picture_sum) {
  SlicecastStream *stream;
  int32_t code = slicecast_open(HEAD_PIPELINE(), &head, 0, 0, memory, sizeof memory, &stream, 0);
  uint32_t number;
  while (code >= 0 && slicecast_wanted(stream, &number, 0) == SLICECAST_OK) {
    code = slicecast_push(stream, head_voxels + number * HEAD_SLICE_VOXELS, HEAD_SLICE_VOXELS, 0);
  }
  const void *image;
  size_t bytes;
  if (code < 0 || (code = slicecast_image(stream, &image, &bytes, 0)) < 0) {
    return code;
  }
  for (size_t i = 0; i < bytes / 2; ++i) {
    *image_sum = add(*image_sum, ((const uint16_t *)image)[i]);
  }
  for (uint32_t y = 0; y < HEAD_ROWS; ++y) {
    code = slicecast_picture_row(stream, &head_warp, y, head_background, row, sizeof row, 0);
    if (code < 0) {
      return code;
    }
    for (const uint8_t *rgb = row; rgb < row + sizeof row; rgb += 3) {
      *picture_sum = add(*picture_sum, rgb[0] | (uint32_t)rgb[1] << 8 | (uint32_t)rgb[2] << 16);
    }
  }
  return code;
}

int main(void) {
  uint32_t image = 0, picture = 0;
  put("case exported head\n");
  int passed = frame(&image, &picture) >= 0;
  put("image ");
  put_hex(image);
  put("\npicture ");
  put_hex(picture);
  passed &= image == IMAGE_SUM && picture == PICTURE_SUM;
  put(passed ? "\nverdict pass\n" : "\nverdict fail\n");
  return verdict(passed);
}
