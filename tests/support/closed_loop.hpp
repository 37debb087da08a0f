// The closed loop, as the tests name it.
#pragma once

#include "deploy/tools/loop/closed_loop.hpp"

namespace hoist::tests {

using namespace loop;

}  // namespace hoist::tests
