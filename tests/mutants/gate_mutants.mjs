// gate_mutants.mjs HEADER OUT: writes a copy of the safety gate in which every comparison, connective, sign, negation, number and remembering
// statement can be changed at run time (environment GATE_MUTANT=N changes the Nth, none without it), and prints what each N is, one per line.
// One compilation serves all mutants. Used by `deploy/dev cover --mutants`.
import { mkdirSync, readFileSync, writeFileSync } from 'node:fs';
import { dirname } from 'node:path';

const [input, output] = process.argv.slice(2);
let text = readFileSync(input, 'utf8').replace(/\/\/.*$/gm, '');
const whole = text;
const mutants = [];
let line = 0;
const add = (what) => mutants.push(`line ${line}: ${what}`) - 1;
const pick = (what, changed, same) => `(gate_mutant(${add(what)}) ? (${changed}) : (${same}))`;

// An expression as the gate is written in: C++'s operators by their rank, calls, casts, members, braced lists.
const ranks = [['||'], ['&&'], ['|'], ['&'], ['==', '!='], ['<', '>', '<=', '>='], ['<<', '>>'], ['+', '-'], ['*', '/']];
const changes = {
  '||': ['&&'], '&&': ['||'], '==': ['!='], '!=': ['=='], '<': ['<=', '>='], '>': ['>=', '<='], '<=': ['<', '>'], '>=': ['>', '<'],
  '+': ['-'], '-': ['+'], '*': ['/'], '/': ['*'], '|': ['&'], '&': [], '<<': [], '>>': [],
};
class Parser {
  constructor(source) {
    this.tokens = source.match(/\d[\d.]*(?:e-?\d+)?\w*|[A-Za-z_]\w*(?:::[A-Za-z_]\w*)*(?:<[\w:]+>)?|->|\|\||&&|[=!<>]=|<<|>>|[-+*/&|!~<>()[\]{}.,?:]/g) ?? [];
    this.at = 0;
  }
  get next() { return this.tokens[this.at]; }
  take(token) {
    if (token !== undefined && this.next !== token) throw new Error(`line ${line}: '${this.next}' instead of '${token}' in ${this.tokens.join(' ')}`);
    return this.tokens[this.at++];
  }
  expression() {
    const condition = this.binary(0);
    if (this.next !== '?') return condition;
    this.take();
    const yes = this.expression();
    this.take(':');
    return `(${condition} ? ${yes} : ${this.expression()})`;
  }
  binary(rank) {
    if (rank === ranks.length) return this.unary();
    let left = this.binary(rank + 1);
    while (ranks[rank].includes(this.next)) {
      const operator = this.take();
      const right = this.binary(rank + 1);
      let result = `${left} ${operator} ${right}`;
      // Exact equality of measured numbers is irrelevant: their bounds allow for rounding.
      const measured = /_m_s|_rad|speed|turn|value|share/.test(left + right);
      const others = changes[operator].filter((other) => !measured || !'<=>='.includes(operator) || other[0] !== operator[0]);
      for (const other of others) result = pick(`${operator} becomes ${other}`, `${left} ${other} ${right}`, result);
      left = `(${result})`;
    }
    return left;
  }
  unary() {
    if (this.next === '!') {
      this.take();
      const inner = this.unary();
      return pick('! is left out', `static_cast<bool>(${inner})`, `!${inner}`);
    }
    if (['-', '*', '&', '~'].includes(this.next)) return this.take() + this.unary();
    return this.postfix();
  }
  list(close) {
    const items = [];
    while (this.next !== close) {
      items.push(this.expression());
      if (this.next === ',') this.take();
    }
    this.take(close);
    return items.join(', ');
  }
  postfix() {
    const token = this.take();
    let result = token;
    if (token === '(') result = `(${this.list(')')})`;
    else if (token === '{') return `{${this.list('}')}}`;
    else if (token === 'true' || token === 'false') return pick(`${token} is turned`, `!${token}`, token);
    else if (/^\d/.test(token)) return pick(`${token} is one more`, `${token} + 1`, token);
    for (;;) {
      if (this.next === '(') {
        this.take();
        result += `(${this.list(')')})`;
      } else if (this.next === '[') {
        this.take();
        result += `[${this.list(']')}]`;
      } else if (this.next === '.' || this.next === '->') result += this.take() + this.take();
      else return result;
    }
  }
}
const mutate = (source, from) => {
  line = whole.slice(0, from).split('\n').length;
  const parser = new Parser(source);
  const result = parser.expression();
  if (parser.next !== undefined) throw new Error(`line ${line}: cannot read ${source}`);
  return result;
};

// Where expressions stand: conditions, returned values, initial values; and statements that remember something.
const pieces = [];
const patterns = [
  { form: /\breturn ([^;]+);/g, write: (m, e) => `return ${e};` },
  { form: /\n\s+(?:const )?(?:auto|double|bool|std::uint16_t|Motion) (\w+) = ([^;]+);/g, group: 2, write: (m, e) => m[0].replace(m[2], () => e) },
  { form: /\n\s+(gain_m_s = )([^;]+);/g, group: 2, write: (m, e) => m[0].replace(m[2], () => e) },
];
for (const { form, group = 1, write } of patterns)
  for (const m of whole.matchAll(form)) {
    // Members' first values are no expressions.
    if (group === 2 && /^(?:0|0\.0|false|true)\b/.test(m[group])) continue;
    pieces.push({ from: m.index, to: m.index + m[0].length, text: () => write(m, mutate(m[group], m.index + m[0].indexOf(m[group]))) });
  }
for (const m of whole.matchAll(/\bif \(/g)) {
  let depth = 1, end = m.index + m[0].length;
  while (depth > 0) depth += { '(': 1, ')': -1 }[whole[end++]] ?? 0;
  const inner = whole.slice(m.index + m[0].length, end - 1);
  pieces.push({ from: m.index, to: end, text: () => `if (${mutate(inner, m.index)})` });
}
for (const m of whole.matchAll(/\n(\s+)((?:sent_ = next|sent = \{[^;]+\}|alone_ticks_ = 0|\+\+alone_ticks_|wheel\.\w+ = [^;]+));/g))
  pieces.push({ from: m.index, to: m.index + m[0].length, text: () => {
    line = whole.slice(0, m.index).split('\n').length + 1;
    return `\n${m[1]}if (!gate_mutant(${add(`left out: ${m[2].split('=')[0].trim()}`)})) ${m[2]};`;
  } });
for (const m of whole.matchAll(/static constexpr (double|std::uint8_t) (kRounding_m_s|kLettingGo_m_s2|kAway_m_s|kAloneTicks) = ([^;]+);/g))
  pieces.push({ from: m.index, to: m.index + m[0].length, text: () => {
    line = whole.slice(0, m.index).split('\n').length;
    const value = pick(`${m[2]} doubled`, `2 * ${m[3]}`, pick(`${m[2]} halved`, `${m[3]} / 2`, m[3]));
    return `static inline const ${m[1]} ${m[2]} = static_cast<${m[1]}>(${value});`;
  } });
pieces.sort((a, b) => a.from - b.from);
let out = '', done = 0;
for (const piece of pieces) {
  if (piece.from < done) continue;
  out += whole.slice(done, piece.from) + piece.text();
  done = piece.to;
}
out += whole.slice(done);
out = out.replace(/static constexpr bool/g, 'static bool').replace('namespace hoist::core {', `#include <cstdlib>
namespace hoist::core {
inline bool gate_mutant(int number) {
  static const char* const text = std::getenv("GATE_MUTANT");
  static const int chosen = text == nullptr ? -1 : std::atoi(text);
  return number == chosen;
}`);
mkdirSync(dirname(output), { recursive: true });
writeFileSync(output, out);
mutants.forEach((what, i) => console.log(`${i}\t${what}`));
