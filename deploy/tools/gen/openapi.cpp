// The REST interface for other tools: the server's own description, committed so that changes are reviewed.
#include "server/contract/openapi.hpp"

#include <nlohmann/json.hpp>

#include "deploy/tools/gen/generate.hpp"

namespace hoist::gen {

GeneratedFile openapi_file() {
  auto document = server::openapi_document();
  document["x-made-by"] = made_from("server/contract/api.def and schemas.cpp");
  return {"server/contract/openapi.gen.json", document.dump(2) + "\n"};
}

}  // namespace hoist::gen
