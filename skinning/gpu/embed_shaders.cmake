# gelenk_embed_shaders(TARGET FUNCTION FILE...): compiles a function of that name, declared by hand, into TARGET, which returns the
# files' text as a ShaderFolder. Configure time only: touching a shader makes CMake run again before the build.
function(gelenk_embed_shaders target function)
  set(entries "")
  foreach(file ${ARGN})
    set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS "${file}")
    file(READ "${file}" text)
    get_filename_component(name "${file}" NAME)
    string(APPEND entries "    {\"${name}\", R\"glsl(${text})glsl\"},\n")
  endforeach()
  file(GENERATE OUTPUT "${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp" CONTENT
"#include \"skinning/gpu/shader_program.h\"
namespace gelenk {
ShaderFolder ${function}();
ShaderFolder ${function}() {
  static constexpr ShaderText files[] = {
${entries}  };
  return files;
}
}  // namespace gelenk
")
  target_sources(${target} PRIVATE "${CMAKE_CURRENT_BINARY_DIR}/${function}.cpp")
endfunction()
