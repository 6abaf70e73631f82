# `cmake --build build --target package`: one archive per host, meshlab-point-surfaces-<version>-<host>.tar.gz, that holds the
# plugins, the licence, how to install them, what the filters' parameters are, and a script for each.
set(CPACK_PACKAGE_NAME meshlab-point-surfaces)
set(CPACK_PACKAGE_VENDOR "MeshLab Point Surfaces")
set(CPACK_PACKAGE_VERSION ${PROJECT_VERSION})
set(CPACK_PACKAGE_FILE_NAME ${CPACK_PACKAGE_NAME}-${PROJECT_VERSION})
set(CPACK_GENERATOR TGZ)
set(CPACK_ARCHIVE_COMPONENT_INSTALL ON)
set(CPACK_COMPONENTS_GROUPING ONE_PER_GROUP)
set(CPACK_INCLUDE_TOPLEVEL_DIRECTORY OFF)
set(CPACK_COMPONENTS_ALL ${POINT_SURFACES_HOST_LIST})
foreach(host IN LISTS POINT_SURFACES_HOST_LIST)
    install(FILES ${PROJECT_SOURCE_DIR}/LICENSE ${PROJECT_SOURCE_DIR}/cmake/INSTALL.md ${PROJECT_SOURCE_DIR}/FILTERS.md
        DESTINATION ${host} COMPONENT ${host})
    install(DIRECTORY ${PROJECT_SOURCE_DIR}/examples DESTINATION ${host} COMPONENT ${host} FILES_MATCHING PATTERN "*.mlx")
endforeach()
include(CPack)
