# Libraries of the geometry core and their tests.
find_package(Eigen3 3.3 REQUIRED NO_MODULE)
find_package(Threads REQUIRED)
find_package(CGAL 5.5 REQUIRED)

# What every source of ours is compiled with. -O3: the inner loops are ours, not only CGAL's.
add_library(recon_settings INTERFACE)
target_compile_options(recon_settings INTERFACE -Wall -Wextra $<$<CONFIG:Release>:-O3>)
if(NOT CMAKE_SYSTEM_PROCESSOR MATCHES "x86_64|AMD64")
    # ARM would fuse multiplications and additions everywhere: last bits, and what hangs on them, as on plain x86-64.
    target_compile_options(recon_settings INTERFACE -ffp-contract=off)
endif()
target_include_directories(recon_settings INTERFACE ${PROJECT_SOURCE_DIR} ${PROJECT_SOURCE_DIR}/common)
target_link_libraries(recon_settings INTERFACE Eigen3::Eigen Threads::Threads)

# recon_library(<name> SOURCES <file>... [CGAL_SOURCES <file>...] [LINK <target>...])
# CGAL_SOURCES are the few translation units that instantiate CGAL; only they need its flags (-frounding-math is slow
# elsewhere).
function(recon_library name)
    cmake_parse_arguments(ARG "" "" "SOURCES;CGAL_SOURCES;LINK" ${ARGN})
    add_library(${name} STATIC ${ARG_SOURCES})
    target_link_libraries(${name} PUBLIC recon_settings ${ARG_LINK})
    if(ARG_CGAL_SOURCES)
        add_library(${name}_cgal OBJECT ${ARG_CGAL_SOURCES})
        target_link_libraries(${name}_cgal PUBLIC recon_settings ${ARG_LINK} PRIVATE CGAL::CGAL)
        target_compile_definitions(${name}_cgal PRIVATE CGAL_NDEBUG)
        target_sources(${name} PRIVATE $<TARGET_OBJECTS:${name}_cgal>)
        target_link_libraries(${name} PUBLIC gmp mpfr)
    endif()
endfunction()

# recon_test(<name> SOURCES <file>... LINK <target>...): one GoogleTest program, found by ctest.
function(recon_test name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
    add_executable(${name} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE ${ARG_LINK} GTest::gtest GTest::gtest_main)
    gtest_discover_tests(${name} DISCOVERY_TIMEOUT 60)
endfunction()
