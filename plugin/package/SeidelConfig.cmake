# The target Seidel::seidel, the C library of Seidel.
get_filename_component(_seidel_prefix "${CMAKE_CURRENT_LIST_DIR}/../../.." ABSOLUTE)

if(NOT TARGET Seidel::seidel)
    add_library(Seidel::seidel SHARED IMPORTED)
    set_target_properties(Seidel::seidel PROPERTIES
        INTERFACE_INCLUDE_DIRECTORIES "${_seidel_prefix}/include"
        IMPORTED_LOCATION "${_seidel_prefix}/lib/@LIBRARY@"
        IMPORTED_IMPLIB "${_seidel_prefix}/lib/@IMPORT_LIBRARY@")
endif()

unset(_seidel_prefix)
