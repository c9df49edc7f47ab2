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

# The shaders of skinning/gpu, as skinningShaders(). skin_methods.glsl includes all parts of the skinning methods: a new one belongs
# to them by lying there.
function(gelenk_embed_skinning_shaders target)
  file(GLOB shaders CONFIGURE_DEPENDS "${CMAKE_CURRENT_FUNCTION_LIST_DIR}/shaders/*")
  set(parts "")
  foreach(file ${shaders})
    get_filename_component(name "${file}" NAME)
    if(name MATCHES "^skin_.*\\.glsl$" AND NOT name STREQUAL "skin_bones.glsl")
      string(APPEND parts "#include \"${name}\"\n")
    endif()
  endforeach()
  file(CONFIGURE OUTPUT skin_methods.glsl CONTENT "${parts}" @ONLY)
  gelenk_embed_shaders(${target} skinningShaders ${shaders} "${CMAKE_CURRENT_BINARY_DIR}/skin_methods.glsl")
endfunction()
