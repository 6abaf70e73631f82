# The hosts of the plugins and how a plugin is built for each: point_surfaces_plugin().
#
# Headers and libraries are taken from the cache that cmake/setup fills, from the installed packages, or from
#   MESHLAB_SOURCE_DIR   a MeshLab checkout (with vcglib) of the host to build for; then only this host is built
#   MESHLAB_LIBRARY      its libmeshlab-common.so
#   MESHLAB_SCALAR       float (default) or double, as it was built
# Each default can be changed alone: MESHLAB_2020_SOURCE_DIR, MESHLAB_2020_LIBRARY, MESHLAB_2025_SOURCE_DIR,
# MESHLAB_2025_LIBRARY, PYMESHLAB_LIBRARY. A host of which something is missing is left out with a message.
include(GNUInstallDirs)

set(MESHLAB_SOURCE_DIR "" CACHE PATH "MeshLab checkout of the only host to build for")
set(MESHLAB_LIBRARY "" CACHE FILEPATH "libmeshlab-common.so of the only host to build for")
set(MESHLAB_SCALAR "float" CACHE STRING "Scalar type of the only host to build for")

# Versions, hashes and the cache's folders are written once, in a file that the shell reads too.
file(STRINGS ${PROJECT_SOURCE_DIR}/cmake/hosts.env host_lines REGEX "^[A-Z0-9_]+=")
foreach(line IN LISTS host_lines)
    string(REGEX MATCH "^([A-Z0-9_]+)=(.*)$" _ "${line}")
    set(HOSTS_${CMAKE_MATCH_1} "${CMAKE_MATCH_2}")
endforeach()
if(DEFINED ENV{XDG_CACHE_HOME} AND NOT "$ENV{XDG_CACHE_HOME}" STREQUAL "")
    set(hosts_cache "$ENV{XDG_CACHE_HOME}/meshlab-point-surfaces")
else()
    set(hosts_cache "$ENV{HOME}/.cache/meshlab-point-surfaces")
endif()
function(short_hash text result)
    string(SUBSTRING "${text}" 0 12 short)
    set(${result} ${short} PARENT_SCOPE)
endfunction()
short_hash(${HOSTS_MESHLAB_2020_SHA256} hash_2020)
short_hash(${HOSTS_MESHLAB_2025_SHA256} hash_2025)
file(SHA256 ${PROJECT_SOURCE_DIR}/cmake/requirements.txt hash_python)
short_hash(${hash_python} hash_python)
set(MESHLAB_2020_SOURCE_DIR "${hosts_cache}/meshlab-${HOSTS_MESHLAB_2020_VERSION}-${hash_2020}/source" CACHE PATH "")
set(MESHLAB_2020_LIBRARY "/usr/lib/${CMAKE_LIBRARY_ARCHITECTURE}/meshlab/libmeshlab-common.so" CACHE FILEPATH "")
set(MESHLAB_2025_SOURCE_DIR "${hosts_cache}/meshlab-${HOSTS_MESHLAB_2025_VERSION}-${hash_2025}/source" CACHE PATH "")
set(MESHLAB_2025_LIBRARY "${hosts_cache}/meshlab-${HOSTS_MESHLAB_2025_VERSION}-${hash_2025}/lib/libmeshlab-common.so"
    CACHE FILEPATH "")
file(GLOB found_pymeshlab
    "${hosts_cache}/python-${hash_python}/lib/python3*/site-packages/pymeshlab/lib/libmeshlab-common.so")
set(PYMESHLAB_LIBRARY "${found_pymeshlab}" CACHE FILEPATH "libmeshlab-common.so of the pymeshlab wheel")

find_package(Qt5 5.12 REQUIRED COMPONENTS Core Gui Widgets OpenGL Xml)
# MeshLab 2020's headers include QtScript's successor only in name: QJSEngine of Qt5Qml, headers only.
find_path(QT5_QML_INCLUDE_DIR QJSEngine PATHS ${Qt5Core_INCLUDE_DIRS} PATH_SUFFIXES ../QtQml QtQml NO_DEFAULT_PATH)

set(POINT_SURFACES_HOST_LIST "")

# point_surfaces_host(<name> INTERFACE 2020|2021 VERSION <version> SCALAR float|double LIBRARY <file> INCLUDE <dir>...)
# Makes plugin_adapter_<name>: all that the plugins for this host share, compiled once.
function(point_surfaces_host name)
    cmake_parse_arguments(ARG "" "INTERFACE;VERSION;SCALAR;LIBRARY" "INCLUDE" ${ARGN})
    foreach(needed IN LISTS ARG_LIBRARY ARG_INCLUDE)
        if(NOT EXISTS "${needed}")
            message(STATUS "No plugins for ${name}: '${needed}' does not exist (run cmake/setup, or see cmake/meshlab_hosts.cmake)")
            return()
        endif()
    endforeach()
    set(seam ${PROJECT_SOURCE_DIR}/common/meshlab)
    add_library(plugin_host_${name} INTERFACE)
    target_include_directories(plugin_host_${name} SYSTEM INTERFACE ${ARG_INCLUDE} ${QT5_QML_INCLUDE_DIR})
    target_compile_definitions(plugin_host_${name} INTERFACE MESHLAB_SCALAR=${ARG_SCALAR} MESHLAB_VERSION=${ARG_VERSION})
    target_link_libraries(plugin_host_${name} INTERFACE
        ${ARG_LIBRARY} Qt5::Core Qt5::Gui Qt5::Widgets Qt5::OpenGL Qt5::Xml Eigen3::Eigen)

    add_library(plugin_adapter_${name} OBJECT
        ${seam}/host_document.cpp
        ${seam}/read_layer.cpp
        ${seam}/write_result.cpp
        ${seam}/interface_${ARG_INTERFACE}/adapter.cpp
        ${seam}/interface_${ARG_INTERFACE}/adapter.h)
    set_target_properties(plugin_adapter_${name} PROPERTIES AUTOMOC ON)
    target_include_directories(plugin_adapter_${name} PRIVATE ${seam}/interface_${ARG_INTERFACE})
    target_link_libraries(plugin_adapter_${name} PUBLIC plugin_spec plugin_host_${name})
    set(POINT_SURFACES_HOST_LIST ${POINT_SURFACES_HOST_LIST} ${name} PARENT_SCOPE)
endfunction()

if(MESHLAB_SOURCE_DIR)
    file(READ "${MESHLAB_SOURCE_DIR}/ML_VERSION" version)
    string(STRIP "${version}" version)
    set(interface 2021)
    set(vcglib "${MESHLAB_SOURCE_DIR}/src/vcglib")
    if(EXISTS "${MESHLAB_SOURCE_DIR}/src/common/interfaces.h")
        set(interface 2020)
        set(vcglib "${MESHLAB_SOURCE_DIR}/vcglib")
    endif()
    point_surfaces_host(meshlab-${version} INTERFACE ${interface} VERSION ${version} SCALAR ${MESHLAB_SCALAR}
        LIBRARY "${MESHLAB_LIBRARY}" INCLUDE "${MESHLAB_SOURCE_DIR}/src" "${vcglib}")
else()
    point_surfaces_host(meshlab-${HOSTS_MESHLAB_2020_VERSION} INTERFACE 2020 VERSION ${HOSTS_MESHLAB_2020_VERSION}
        SCALAR float LIBRARY "${MESHLAB_2020_LIBRARY}"
        INCLUDE "${MESHLAB_2020_SOURCE_DIR}/src" "${MESHLAB_2020_SOURCE_DIR}/vcglib")
    point_surfaces_host(meshlab-${HOSTS_MESHLAB_2025_VERSION} INTERFACE 2021 VERSION ${HOSTS_MESHLAB_2025_VERSION}
        SCALAR float LIBRARY "${MESHLAB_2025_LIBRARY}"
        INCLUDE "${MESHLAB_2025_SOURCE_DIR}/src" "${MESHLAB_2025_SOURCE_DIR}/src/vcglib")
    point_surfaces_host(pymeshlab-${HOSTS_PYMESHLAB_VERSION} INTERFACE 2021 VERSION ${HOSTS_MESHLAB_2025_VERSION}
        SCALAR double LIBRARY "${PYMESHLAB_LIBRARY}"
        INCLUDE "${MESHLAB_2025_SOURCE_DIR}/src" "${MESHLAB_2025_SOURCE_DIR}/src/vcglib")
endif()
