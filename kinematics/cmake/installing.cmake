# cmake --install: libraries, headers below include/gelenk, and the package that find_package(Gelenk) finds.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/Gelenk)

foreach(name kinematics solvers skinning)
  set_target_properties(gelenk_${name} PROPERTIES EXPORT_NAME ${name})
  target_include_directories(gelenk_${name} INTERFACE $<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>)
endforeach()
install(TARGETS gelenk_kinematics gelenk_solvers gelenk_skinning EXPORT GelenkTargets
        ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
install(EXPORT GelenkTargets NAMESPACE Gelenk:: DESTINATION ${package_folder})
if(TARGET gelenk)
  install(TARGETS gelenk RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
endif()

# Headers of the libraries, without those of parts that are left out. In the tree they name each other from its root;
# installed they say gelenk/ before that, so that no other project's kinematics/ is found instead.
file(GLOB headers CONFIGURE_DEPENDS RELATIVE ${PROJECT_SOURCE_DIR} kinematics/*.h kinematics/*/*.h
     solvers/*.h solvers/*/*.h skinning/*.h skinning/*/*.h)
list(FILTER headers EXCLUDE REGEX "^(solvers/lab|solvers/peers|skinning/gpu)/|/gltf_joints\\.h$")  # the last: inside the reader
if(NOT GELENK_CERES)
  list(FILTER headers EXCLUDE REGEX "^solvers/ceres/")
endif()
if(NOT GELENK_URDF)
  list(FILTER headers EXCLUDE REGEX "/urdf[a-z_]*\\.h$")
endif()
if(NOT GELENK_GLTF)
  list(FILTER headers EXCLUDE REGEX "/gltf\\.h$")
endif()
install(CODE "
  foreach(header ${headers})
    file(READ \"${PROJECT_SOURCE_DIR}/\${header}\" text)
    string(REGEX REPLACE \"#include \\\"(kinematics|solvers|skinning)/\" \"#include \\\"gelenk/\\\\1/\" text \"\${text}\")
    file(WRITE \"\$ENV{DESTDIR}\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/gelenk/\${header}\" \"\${text}\")
  endforeach()")

foreach(part KDL COLLADA)
  if(NOT GELENK_WITH_${part})
    set(GELENK_WITH_${part} OFF)
  endif()
endforeach()
configure_package_config_file(kinematics/cmake/GelenkConfig.cmake.in ${PROJECT_BINARY_DIR}/GelenkConfig.cmake
                              INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(${PROJECT_BINARY_DIR}/GelenkConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${PROJECT_BINARY_DIR}/GelenkConfig.cmake ${PROJECT_BINARY_DIR}/GelenkConfigVersion.cmake
        DESTINATION ${package_folder})
