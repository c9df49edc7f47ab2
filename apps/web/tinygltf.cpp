// The code of TinyGLTF and of stb's decoder of pictures, which the distribution has as libraries of its own
// machine.
#define TINYGLTF_IMPLEMENTATION
#define STB_IMAGE_IMPLEMENTATION
#include <nlohmann/json.hpp>

#include "tiny_gltf.h"
