# point_surfaces_plugin(<name> SOURCES plugin.cpp... LINK recon_x...)
# Compiles the filter's description once (target <name>_spec) and links it into one plugin per host,
# build/plugins/<host>/lib<name>.so.
add_custom_target(plugins)
function(point_surfaces_plugin name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINK" ${ARGN})
    add_library(${name}_spec STATIC ${ARG_SOURCES})
    target_link_libraries(${name}_spec PUBLIC plugin_spec ${ARG_LINK})
    foreach(host IN LISTS POINT_SURFACES_HOST_LIST)
        set(target ${name}-${host})
        add_library(${target} MODULE $<TARGET_OBJECTS:plugin_adapter_${host}>)
        target_link_libraries(${target} PRIVATE ${name}_spec plugin_host_${host})
        # Nothing but Qt's entry points is visible, nothing is linked that is not used, and no path of the machine that
        # built it is left inside: the host has loaded its own libmeshlab-common before.
        target_link_options(${target} PRIVATE
            -Wl,--version-script=${PROJECT_SOURCE_DIR}/cmake/plugin.map -Wl,--as-needed -Wl,--gc-sections
            $<$<CONFIG:Release>:-s>)
        set_target_properties(${target} PROPERTIES
            OUTPUT_NAME ${name}
            PREFIX lib
            LINKER_LANGUAGE CXX
            SKIP_BUILD_RPATH ON
            LINK_DEPENDS ${PROJECT_SOURCE_DIR}/cmake/plugin.map
            LIBRARY_OUTPUT_DIRECTORY ${PROJECT_BINARY_DIR}/plugins/${host})
        add_dependencies(plugins ${target})
        install(TARGETS ${target} LIBRARY DESTINATION ${host} COMPONENT ${host})
    endforeach()
endfunction()
