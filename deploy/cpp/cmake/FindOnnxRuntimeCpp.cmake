# onnxruntime's C++ headers and its library, as the target OnnxRuntimeCpp::OnnxRuntimeCpp.
#
# Looks in ONNXRUNTIME_ROOT (a CMake or environment variable: a release tarball, unpacked), then where systems and ROS
# keep them. onnxruntime's own CMake files are not asked: the release tarballs of several versions ship broken ones.
find_path(
  OnnxRuntimeCpp_INCLUDE_DIR onnxruntime_cxx_api.h
  HINTS ${ONNXRUNTIME_ROOT} ENV ONNXRUNTIME_ROOT
  PATH_SUFFIXES include include/onnxruntime include/onnxruntime/core/session onnxruntime)
find_library(
  OnnxRuntimeCpp_LIBRARY onnxruntime
  HINTS ${ONNXRUNTIME_ROOT} ENV ONNXRUNTIME_ROOT
  PATH_SUFFIXES lib lib64)

include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(
  OnnxRuntimeCpp
  REQUIRED_VARS OnnxRuntimeCpp_LIBRARY OnnxRuntimeCpp_INCLUDE_DIR
  REASON_FAILURE_MESSAGE "unpack a release tarball of onnxruntime and give -DONNXRUNTIME_ROOT=<its folder>")

if(OnnxRuntimeCpp_FOUND AND NOT TARGET OnnxRuntimeCpp::OnnxRuntimeCpp)
  add_library(OnnxRuntimeCpp::OnnxRuntimeCpp UNKNOWN IMPORTED)
  # Imported, so its headers count as the system's: our warnings are not for them.
  set_target_properties(
    OnnxRuntimeCpp::OnnxRuntimeCpp PROPERTIES IMPORTED_LOCATION ${OnnxRuntimeCpp_LIBRARY} INTERFACE_INCLUDE_DIRECTORIES
                                                                                      ${OnnxRuntimeCpp_INCLUDE_DIR})
endif()
mark_as_advanced(OnnxRuntimeCpp_INCLUDE_DIR OnnxRuntimeCpp_LIBRARY)
