"""The grammar of IDL, for lark: OMG IDL 3.5 and the types and annotations of IDL 4.

The words that IDL 4 added (``map``, ``int8`` …) are names here, since older files use them as
names; the reader knows where they are types. What annotations and value types refer to has rules
of its own (``mark``, ``value_base``): they are followed by other words than a type is, and a
parser that looks one word ahead would take those words for keywords behind types, too.

See decision 10.
"""

from __future__ import annotations

GRAMMAR = r"""
start: _definition*

_definition: annotation* _defined ";" | ";"
_defined: module | interface | forward_interface | _type_defined | constant | exception
    | valuetype | forward_value
_type_defined: structure | forward_structure | union | forward_union | enumeration | typedef
    | native

module: "module" NAME "{" _definition* "}"

interface: _interface_kind? "interface" NAME inheritance? "{" _export* "}"
forward_interface: _interface_kind? "interface" NAME
_interface_kind: "abstract" | "local"
inheritance: ":" scoped ("," scoped)*
_export: annotation* (operation | attribute | _type_defined | constant | exception) ";" | ";"
operation: "oneway"? _result NAME "(" (parameter ("," parameter)*)? ")" raises? context?
_result: void | _type
void: "void"
parameter: annotation* DIRECTION _type NAME
DIRECTION.2: /\b(inout|in|out)\b/
raises: "raises" "(" scoped ("," scoped)* ")"
context: "context" "(" STRING ("," STRING)* ")"
attribute: [READONLY] "attribute" _type NAME ("," NAME)* _attribute_raises*
READONLY: "readonly"
_attribute_raises: raises | "getraises" names | "setraises" names
names: "(" scoped ("," scoped)* ")"

structure: "struct" NAME inheritance? "{" member* "}"
forward_structure: "struct" NAME
exception: "exception" NAME "{" member* "}"
member: annotation* _type declarator ("," declarator)* ";"
declarator: NAME size*
size: "[" _constant "]"

union: "union" NAME "switch" "(" annotation* _type ")" "{" case+ "}"
forward_union: "union" NAME
case: label+ annotation* _type declarator ";"
label: "case" _constant ":" | "default" ":"

enumeration: "enum" NAME "{" enumerator ("," enumerator)* ","? "}"
enumerator: annotation* NAME

typedef: "typedef" _type declarator ("," declarator)*
native: "native" NAME
constant: "const" _type NAME "=" _constant

valuetype: _value_kind? "valuetype" NAME _value_tail
forward_value: _value_kind? "valuetype" NAME
_value_kind: "custom" | "abstract"
_value_tail: _value_bases? "{" _value_element* "}" | _type
_value_bases: ":" "truncatable"? value_base ("," value_base)* supports? | supports
supports: "supports" value_base ("," value_base)*
value_base: [ROOT] NAME ("::" NAME)*
_value_element: _export | ("public" | "private") member | factory ";"
factory: "factory" NAME "(" (parameter ("," parameter)*)? ")" raises?

_type: basic | text | sequence | fixed | scoped | map
basic: WORD+
WORD.2: /\b(unsigned|short|long|float|double|char|wchar|boolean|octet|any|Object|ValueBase)\b/
text: TEXT ["<" _constant ">"]
TEXT.2: /\bw?string\b/
sequence: "sequence" "<" _type ["," _constant] ">"
map: NAME "<" _type "," _type ["," _constant] ">"
fixed: "fixed" ["<" _constant "," _constant ">"]
scoped: [ROOT] NAME ("::" NAME)*
ROOT: "::"

annotation: "@" mark ("(" (_argument ("," _argument)*)? ")")?
mark: [ROOT] NAME ("::" NAME)*
_argument: _constant | NAME "=" _constant

_constant: or
?or: xor ("|" xor)*
?xor: and ("^" and)*
?and: shift ("&" shift)*
?shift: sum (SHIFT sum)*
?sum: product (SIGN product)*
?product: unary (TIMES unary)*
?unary: (SIGN | TILDE) primary | primary
?primary: literal | scoped | "(" _constant ")"
literal: NUMBER | STRING+ | CHARACTER | TRUTH
SHIFT: /<<|>>/
SIGN: /[+-]/
TIMES: /[*\/%]/
TILDE: "~"
TRUTH.2: /\b(TRUE|FALSE)\b/
NUMBER: /0[xX][0-9a-fA-F]+/ | /([0-9]+\.[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?[dD]?/
    | /[0-9]+[eE][+-]?[0-9]+/ | /[0-9]+[dD]?/
STRING: /L?"(\\.|[^"\\\n])*"/
CHARACTER: /L?'(\\[0-7]{1,3}|\\x[0-9a-fA-F]{1,2}|\\u[0-9a-fA-F]{1,4}|\\.|[^'\\\n])'/
NAME: /_?[A-Za-z][A-Za-z0-9_]*/

COMMENT: /\/\/[^\n]*|\/\*(.|\n)*?\*\//
%ignore COMMENT
%ignore /[ \t\f\v\r\n]+/
"""
