#pragma once

namespace muster::tools {

/// What this program was built from and with, for manifest.json. build_info.cc is generated at
/// build time (cmake/WriteBuildInfo.cmake).
extern const char* const kCommit;  ///< with "-dirty" when files differed; "unknown" outside git
extern const char* const kVersion;
extern const char* const kLcmVersion;
extern const char* const kCompiler;
extern const char* const kBuildType;
extern const char* const kSanitizer;  ///< "" without one

}  // namespace muster::tools
