#include "cameras/camera.h"

#define CAMERA(name) extern const camera_type camera_##name;
#include "cameras/cameras.def"
#undef CAMERA
const camera_type *const camera_types[] = {
#define CAMERA(name) &camera_##name,
#include "cameras/cameras.def"
#undef CAMERA
};
const uint32_t camera_type_count = sizeof camera_types / sizeof camera_types[0];
