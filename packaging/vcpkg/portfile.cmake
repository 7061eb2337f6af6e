# SPDX-License-Identifier: Apache-2.0
# An overlay port of the checkout it lies in; in the registry the next line becomes vcpkg_from_github() of a release.
get_filename_component(SOURCE_PATH "${CMAKE_CURRENT_LIST_DIR}/../.." ABSOLUTE)
vcpkg_check_linkage(ONLY_STATIC_LIBRARY)

# The letters of pictures are built in. Checked by the sum that others publish of it, which is SHA-256.
vcpkg_download_distfile(font_archive
    URLS "https://github.com/dejavu-fonts/dejavu-fonts/releases/download/version_2_37/dejavu-fonts-ttf-2.37.tar.bz2"
    FILENAME "dejavu-fonts-ttf-2.37.tar.bz2"
    SKIP_SHA512
)
file(SHA256 "${font_archive}" font_sum)
if(NOT font_sum STREQUAL "fa9ca4d13871dd122f61258a80d01751d603b4d3ee14095d65453b4e846e17d7")
    message(FATAL_ERROR "${font_archive} is not the font that was expected")
endif()
vcpkg_extract_source_archive(font_folder ARCHIVE "${font_archive}")

vcpkg_check_features(OUT_FEATURE_OPTIONS feature_options
    FEATURES
        formats QUENCH_ASSIMP
        formats QUENCH_TIFF
        formats QUENCH_JPEG
        formats QUENCH_ZSTD
        formats QUENCH_BLOSC
        formats QUENCH_HDF5
        formats QUENCH_GDCM
        tools QUENCH_PROGRAM
)
vcpkg_cmake_configure(
    SOURCE_PATH "${SOURCE_PATH}"
    OPTIONS
        ${feature_options}
        -DQUENCH_TESTS=OFF
        -DQUENCH_BENCH=OFF
        -DQUENCH_PYTHON=OFF
        -DQUENCH_VIEWER=OFF  # needs npm and a network
        -DQUENCH_WERROR=OFF
        "-DQUENCH_FONT=${font_folder}/ttf/DejaVuSans.ttf"
)
vcpkg_cmake_install()
vcpkg_cmake_config_fixup(CONFIG_PATH lib/cmake/quench)
vcpkg_fixup_pkgconfig()
if("tools" IN_LIST FEATURES)
    vcpkg_copy_tools(TOOL_NAMES quench AUTO_CLEAN)
endif()
file(REMOVE_RECURSE "${CURRENT_PACKAGES_DIR}/debug/include" "${CURRENT_PACKAGES_DIR}/debug/share" "${CURRENT_PACKAGES_DIR}/share/doc"
     "${CURRENT_PACKAGES_DIR}/share/man")
vcpkg_install_copyright(FILE_LIST "${SOURCE_PATH}/LICENSE" "${SOURCE_PATH}/packaging/debian/copyright")
