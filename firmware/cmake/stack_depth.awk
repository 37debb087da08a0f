# The deepest stack of a finished Cortex-M0 image, from its machine code: frames and calls of every function that reset or an interrupt can
# reach. Input: `objdump -s -j .text IMAGE`, then `objdump -d --no-show-raw-insn IMAGE`. Output: one line "BYTES PATH"; on what cannot be
# bounded a line "problem: ..." and exit code 1.
#
# depth = deepest call path from reset + for each interrupt handler its deepest path and the 36 bytes that the processor saves (8 registers
# and up to one word of alignment). All handlers at once: nested by priority at most one of each can be active.
#
# A call through a pointer goes to any function whose address lies in the image; a function that is called so may itself call one through a
# pointer that calls none (a chip's description and its bus). A routine in ROM takes 128 bytes (UM10398, 26.5: IAP, maximum stack).
# Frames are what all pushes and subtractions of a function add up to, whether or not they lie on one path: an upper bound.

function hex_value(text,   i, value) {
  value = 0
  for (i = 1; i <= length(text); ++i) value = value * 16 + index("0123456789abcdef", substr(text, i, 1)) - 1
  return value
}
function little_endian(word) { return hex_value(substr(word, 7, 2) substr(word, 5, 2) substr(word, 3, 2) substr(word, 1, 2)) }
function call_target(operands,   name) {
  if (operands !~ /<.*>/) return ""
  name = operands
  sub(/^[^<]*</, "", name)
  sub(/>.*$/, "", name)
  sub(/\+0x[0-9a-f]+$/, "", name)
  return name
}
function add_edge(from, to) { if (!((from, to) in edge)) { edge[from, to] = 1; edges[from] = edges[from] " " to } }
# A function at a literal address, with or without the Thumb bit; ROM; or "".
function function_at(address) {
  if (address % 2 == 1) address -= 1
  if (address in name_at) return name_at[address]
  return address >= 536805376 && address < 536870912 ? "ROM" : ""  # 1FFF0000h to 1FFFFFFFh
}
function add_literal_edge(register) {
  if (register in literal) literal_calls[fn] = literal_calls[fn] " " literal[register]
  else indirect[fn] = 1
}

# ---- words of the flash image: vectors, addresses of functions

/^ [0-9a-f]+ / && !disassembling {
  address = hex_value($1)
  if (first_address == "") first_address = address
  for (i = 2; i <= 5 && $i ~ /^[0-9a-f]+$/ && length($i) == 8; ++i) word[address + 4 * (i - 2)] = little_endian($i)
  next
}

# ---- instructions

/^[0-9a-f]+ <.*>:$/ {
  disassembling = 1
  fn = $2
  sub(/^</, "", fn)
  sub(/>:$/, "", fn)
  name_at[hex_value(substr($1, match($1, /[1-9a-f]/)))] = fn
  delete literal
  delete positive
  next
}
/^ +[0-9a-f]+:\t/ {
  n = split($0, part, "\t")
  at = part[1]
  gsub(/[ :]/, "", at)
  operation = part[2]
  operands = part[3]
  if (operation == ".word") { word[hex_value(at)] = hex_value(substr(operands, 3)); next }
  if (operation == "push") { frame[fn] += 4 * split(operands, list, ","); next }
  if (operation == "sub" && operands ~ /^sp, #/) { sub(/^sp, #/, "", operands); frame[fn] += operands; next }
  if (operation == "add" && operands ~ /^sp, r/) {
    register = substr(operands, 5)
    if (register in literal) big_frames[fn] = big_frames[fn] " " literal[register]
    else if (!(register in positive)) problem("frame of " fn " is not constant")
    next
  }
  if (operation ~ /^mov/ && operands ~ /^sp, r[0-6]$/) { problem(fn " sets the stack pointer"); next }
  if (operation == "bl") { add_edge(fn, call_target(operands)); next }
  if (operation == "blx") { add_literal_edge(operands); next }
  if (operation == "bx" && operands != "lr") { add_literal_edge(operands); next }
  if (operation ~ /^b([a-z][a-z])?(\.[nw])?$/) {
    target = call_target(operands)
    if (target != "" && target != fn) add_edge(fn, target)
    next
  }
  register = operands
  sub(/[^a-z0-9].*$/, "", register)
  delete literal[register]
  # A number made of movs and lsls is positive: what gives a frame back.
  if (operation == "movs" && operands ~ /, #/) positive[register] = 1
  else if (operation != "lsls") delete positive[register]
  if (operation == "ldr" && part[4] operands ~ /@ \([0-9a-f]+ /) {
    address = part[4] operands
    sub(/^.*@ \(/, "", address)
    sub(/ .*$/, "", address)
    literal[register] = hex_value(address)
  }
}

# ---- depths

function problem(text) { problems = problems "problem: " text "\n" }
# The deepest path from `name` on; `level`: how many calls through a pointer are on it already.
function depth(name, level,   key, list, i, count, deepest, below, through) {
  key = name "," level
  if (key in known) return known[key]
  if (name == "ROM") { path[key] = "ROM"; return known[key] = 128 }
  if (key in active) { problem("recursion through " name); return 0 }
  active[key] = 1
  deepest = 0
  through = ""
  count = split(edges[name], list, " ")
  for (i = 1; i <= count; ++i) {
    below = depth(list[i], level)
    if (below > deepest) { deepest = below; through = path[list[i] "," level] }
  }
  if (name in indirect) {
    below = indirect_depth(level + 1)
    if (below > deepest) { deepest = below; through = path["*," level + 1] }
  }
  delete active[key]
  path[key] = name "(" frame[name] + 0 ")" (through == "" ? "" : " " through)
  return known[key] = frame[name] + deepest
}
function indirect_depth(level,   name, below, deepest) {
  if (level > 2) { problem("calls through pointers nest deeper than two"); return 0 }
  if (("*," level) in known) return known["*," level]
  deepest = 0
  for (name in taken) {
    if (level == 2 && reaches_indirect(name)) continue
    below = depth(name, level)
    if (below > deepest) { deepest = below; path["*," level] = path[name "," level] }
  }
  return known["*," level] = deepest
}
function reaches_indirect(name,   list, i, count) {
  if (name in indirect) return 1
  if (name in reaches) return reaches[name]
  reaches[name] = 0
  count = split(edges[name], list, " ")
  for (i = 1; i <= count; ++i) if (reaches_indirect(list[i])) return reaches[name] = 1
  return 0
}

END {
  for (name in big_frames) {
    count = split(big_frames[name], list, " ")
    for (i = 1; i <= count; ++i) if (word[list[i]] >= 2147483648) frame[name] += 4294967296 - word[list[i]]
  }
  for (name in literal_calls) {
    count = split(literal_calls[name], list, " ")
    for (i = 1; i <= count; ++i) {
      target = function_at(word[list[i]])
      if (target == "") indirect[name] = 1
      else add_edge(name, target)
    }
  }
  for (address in word)
    if (address >= first_address + 192 && word[address] % 2 == 1 && (word[address] - 1) in name_at) taken[name_at[word[address] - 1]] = 1
  reset = function_at(word[first_address + 4])
  if (reset == "") problem("no reset vector")
  total = depth(reset, 0)
  report = path[reset ",0"]
  for (i = 2; i < 48; ++i) {
    name = function_at(word[first_address + 4 * i])
    if (name == "" || name == reset || name in handled || !(first_address + 4 * i in word)) continue
    handled[name] = 1
    total += depth(name, 0) + 36
    report = report "; interrupt(36) " path[name ",0"]
  }
  printf "%s", problems
  if (problems != "") exit 1
  print total, report
}
