#pragma once

#include <cstdio>
#include <memory>

namespace hoist::tool {

struct CloseFile {
  void operator()(std::FILE* file) const { (void)std::fclose(file); }
};
/// A file of the C library that closes by itself; who must know that all was written closes it and looks at the answer.
using File = std::unique_ptr<std::FILE, CloseFile>;

}  // namespace hoist::tool
