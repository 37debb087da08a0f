// The kinds of rows of the audit log with their words, from server/contract/audit.def. A file of its own: only one screen needs it.
#include <string>

#include "deploy/tools/gen/generate.hpp"
#include "server/contract/audit.hpp"

namespace hoist::gen {

GeneratedFile audit_file() {
  std::string out = "// " + made_from("server/contract/audit.def") + "\n\nimport type { AuditAction, Words } from './rest.gen';\n\n" +
                    "/** What follows the person in a sentence of the audit log: what was done, and what was tried and refused. */\n"
                    "export const auditActions: Readonly<Record<AuditAction, { done: Words; tried: Words }>> = {\n";
  for (const auto& kind : server::kAuditKinds)
    out += "  " + std::string(kind.name) + ": {\n    done: " + words(kind.done_en, kind.done_de) +
           ",\n    tried: " + words(kind.tried_en, kind.tried_de) + ",\n  },\n";
  return {"web/src/contract/audit.gen.ts", out + "};\n"};
}

}  // namespace hoist::gen
