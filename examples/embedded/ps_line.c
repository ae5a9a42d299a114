/* See ps_line.h. A request is taken apart where it stands, in the one line there is. */

#include "ps_line.h"

#include <string.h>

#define DLE 0x10
#define QUIET_MS 500 /* after so long a silence nothing is thrown away any more */
#define DEPTH 4      /* of groups in groups */

static const char HELLO[] = "GET properties";
static const char ALL[] = "all"; /* address of all devices */
static const char *const TOLD[] = {
    "",
    "unknown no such property",
    "no-service there is one service here, it has no name",
    "read-only cannot be set",
    "write-only cannot be read",
    "denied not to be had",
    "syntax not understood",
    "bad-value of another type, or out of range",
    "bad-parameter no such parameter, or no such value of it",
    "busy not now",
    "too-large longer or deeper than a small device can take",
    "checksum the line is damaged",
    "internal it has failed",
};

/* Characters */

static bool is_digit(char c) { return c >= '0' && c <= '9'; }

static bool is_blank(char c) { return c == ' ' || c == '\t' || c == '\r' || c == '\n'; }

static bool is_free(char c)
{
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') ||
           (c != 0 && strchr("_-+~", c) != NULL);
}

static int hex_of(char c)
{
    if (is_digit(c))
        return c - '0';
    if (c >= 'a' && c <= 'f')
        return c - 'a' + 10;
    return c >= 'A' && c <= 'F' ? c - 'A' + 10 : -1;
}

static uint16_t checked(uint16_t check, char byte)
{
    check ^= (uint16_t)((uint16_t)(uint8_t)byte << 8);
    for (uint8_t bit = 0; bit < 8; bit++)
        check = (uint16_t)((uint16_t)(check << 1) ^ ((check & 0x8000u) != 0 ? 0x1021u : 0u));
    return check;
}

/* Sending */

static void say_char(struct ps *ps, char byte)
{
    ps->check = checked(ps->check, byte);
    if (!ps->is_mute)
        ps->send(ps->context, byte);
}

static void say(struct ps *ps, const char *text)
{
    while (*text != 0)
        say_char(ps, *text++);
}

static void say_text(struct ps *ps, const struct ps_text *value)
{
    for (uint8_t i = 0; i < value->length; i++)
        say_char(ps, value->text[i]);
}

static void begin(struct ps *ps, const char *id)
{
    ps->check = 0xFFFF;
    if (ps->address != NULL) {
        say_char(ps, '@');
        say(ps, ps->address);
        say(ps, ": ");
    }
    if (*id != 0) {
        say_char(ps, '#');
        say(ps, id);
        say_char(ps, ' ');
    }
}

static void end(struct ps *ps)
{
    uint16_t check = ps->check;
    if (ps->has_checks) {
        say(ps, " ~");
        for (int8_t shift = 12; shift >= 0; shift = (int8_t)(shift - 4))
            say_char(ps, "0123456789ABCDEF"[(check >> shift) & 15]);
    }
    say_char(ps, '\n');
}

static void answer(struct ps *ps, const char *id, enum ps_code code)
{
    begin(ps, id);
    say(ps, code == PS_OK ? "=" : "! ");
    say(ps, TOLD[code]);
    end(ps);
}

/* Writing values */

static void put_char(struct ps_text *value, char c)
{
    if (value->length == PS_VALUE_BYTES) {
        value->is_full = true;
        return;
    }
    /* What would end the line, or be eaten on the way, cannot be part of it. */
    value->text[value->length++] = (uint8_t)c < 0x20 ? '?' : c;
}

void ps_put(struct ps_text *value, const char *text)
{
    while (*text != 0)
        put_char(value, *text++);
}

void ps_put_number(struct ps_text *value, int32_t number, uint8_t decimals)
{
    char digits[24];
    uint8_t count = 0, least = 0;
    uint32_t rest = number < 0 ? 0u - (uint32_t)number : (uint32_t)number;
    if (decimals > 20)
        decimals = 20;
    while (rest != 0 || count <= decimals) {
        digits[count++] = (char)('0' + rest % 10);
        rest /= 10;
    }
    while (decimals > 0 && least + 1 < decimals && digits[least] == '0')
        least++;
    if (number < 0)
        put_char(value, '-');
    while (count > least) {
        put_char(value, digits[--count]);
        if (count == decimals && decimals != 0)
            put_char(value, '.');
    }
}

void ps_put_string(struct ps_text *value, const char *text)
{
    put_char(value, '"');
    for (; *text != 0; text++) {
        char escaped = *text == '\n' ? 'n' : *text == '\r' ? 'r' : *text == '\t' ? 't' : *text;
        if (escaped != *text || *text == '"' || *text == '\\')
            put_char(value, '\\');
        put_char(value, escaped);
    }
    put_char(value, '"');
}

/* Reading values */

/* Return what follows an escape after its backslash, and its code point; NULL if it is none. */
static const char *unescaped(const char *at, uint32_t *code)
{
    static const char FROM[] = "\"\\nrt", TO[] = "\"\\\n\r\t";
    const char *found = *at == 0 ? NULL : strchr(FROM, *at);
    uint32_t point = 0;
    if (found != NULL) {
        *code = (uint8_t)TO[found - FROM];
        return at + 1;
    }
    if (at[0] != 'u' || at[1] != '{' || hex_of(at[2]) < 0)
        return NULL;
    for (at += 2; hex_of(*at) >= 0 && point <= 0x10FFFF; at++)
        point = point * 16 + (uint32_t)hex_of(*at);
    *code = point;
    return *at == '}' && point <= 0x10FFFF && (point < 0xD800 || point > 0xDFFF) ? at + 1 : NULL;
}

/* Return what is behind one item, NULL if it is none; elements are none for small devices. */
static const char *behind_item(const char *at, enum ps_code *code)
{
    uint8_t depth = 0;
    uint32_t ignored;
    do {
        const char *begin = at;
        while (depth != 0 && is_blank(*at))
            at++;
        if (*at == '(' && ++depth > DEPTH) {
            *code = PS_TOO_LARGE;
            return NULL;
        }
        if (*at == '(' || (*at == ')' && depth != 0)) {
            if (*at++ == ')')
                depth--;
        } else if (*at == '"') {
            at++;
            while (at != NULL && *at != '"')
                at = (uint8_t)*at < 0x20 ? NULL : *at == '\\' ? unescaped(at + 1, &ignored) : at + 1;
            if (at == NULL)
                return NULL;
            at++;
        } else {
            while ((uint8_t)*at > 0x20 && strchr("()<>\"{}", *at) == NULL)
                at++;
            if (at == begin || (depth != 0 && strchr("()\" \t\r\n", *at) == NULL))
                return NULL;
        }
    } while (depth != 0);
    return at;
}

/* Cut a value to its one item; empty text is the empty string. */
static enum ps_code item(char **value)
{
    enum ps_code code = PS_SYNTAX;
    const char *last;
    while (is_blank(**value))
        (*value)++;
    if (**value == 0)
        return PS_OK;
    last = behind_item(*value, &code);
    if (last == NULL)
        return code;
    for (const char *rest = last; *rest != 0; rest++)
        if (!is_blank(*rest))
            return PS_SYNTAX;
    (*value)[last - *value] = 0;
    return PS_OK;
}

enum ps_code ps_take_number(const char *value, uint8_t decimals, int32_t least, int32_t most,
                            int32_t *number)
{
    const char *digits, *at;
    int16_t before = 0, count = 0, exponent = 0, power;
    bool is_negative = *value == '-', is_point = false, is_more = false, is_half = false;
    int64_t whole = 0;
    if (*value == '-' || *value == '+')
        value++;
    digits = value;
    for (; is_digit(*value) || (*value == '.' && !is_point); value++) {
        if (*value == '.')
            is_point = true;
        else if (count < PS_LINE_BYTES) {
            count++;
            before = (int16_t)(before + !is_point);
        }
    }
    at = value;
    if (count != 0 && (*value == 'e' || *value == 'E')) {
        bool is_small = value[1] == '-';
        value += value[1] == '-' || value[1] == '+' ? 2 : 1;
        if (!is_digit(*value))
            return PS_BAD_VALUE;
        for (; is_digit(*value); value++)
            if (exponent < 999)
                exponent = (int16_t)(exponent * 10 + (*value - '0'));
        if (is_small)
            exponent = (int16_t)-exponent;
    }
    if (count == 0 || *value != 0)
        return PS_BAD_VALUE;
    power = (int16_t)(before - 1 + exponent + decimals);
    for (; digits != at; digits++) {
        if (*digits == '.')
            continue;
        if (power < 0) {
            is_more = is_more || *digits != '0';
            is_half = is_half || (power == -1 && *digits >= '5');
        } else if (whole <= INT32_MAX)
            whole = whole * 10 + (*digits - '0');
        power--;
    }
    for (; power >= 0 && whole != 0 && whole <= INT32_MAX; power--)
        whole *= 10;
    if (is_negative)
        whole = -whole;
    /* Digits too small to keep count where they lead out of the range; integers have none. */
    if (whole < least || whole > most || (is_more && decimals == 0) ||
        (is_more && whole == (is_negative ? least : most)))
        return PS_BAD_VALUE;
    if (is_half) /* it is nearer to the next one, which is in the range, too */
        whole += is_negative ? -1 : 1;
    *number = (int32_t)whole;
    return PS_OK;
}

enum ps_code ps_take_word(const char *value, const char *const *words, uint8_t count,
                          uint8_t *word)
{
    for (uint8_t i = 0; i < count; i++)
        if (strcmp(value, words[i]) == 0) {
            *word = i;
            return PS_OK;
        }
    return PS_BAD_VALUE;
}

static size_t utf8(uint32_t code, char *to)
{
    static const uint8_t MARK[] = {0, 0x00, 0xC0, 0xE0, 0xF0};
    uint8_t count = code < 0x80 ? 1 : code < 0x800 ? 2 : code < 0x10000 ? 3 : 4;
    for (uint8_t i = (uint8_t)(count - 1); i > 0; i--, code >>= 6)
        to[i] = (char)(0x80 | (code & 0x3F));
    to[0] = (char)(MARK[count] | code);
    return count;
}

enum ps_code ps_take_string(const char *value, char *text, size_t room)
{
    size_t length = 0;
    /* Twice: what does not fit leaves the old text as it was. */
    for (uint8_t pass = 0; pass < 2; pass++) {
        const char *at = value;
        bool is_quoted = *at == '"';
        length = 0;
        if (is_quoted)
            at++;
        else if (*at == '(')
            return PS_BAD_VALUE;
        while (*at != 0 && !(is_quoted && *at == '"')) {
            char bytes[4];
            size_t count = 1;
            bytes[0] = *at++;
            if (is_quoted && bytes[0] == '\\') {
                uint32_t code = 0;
                at = unescaped(at, &code);
                if (at == NULL || code == 0)
                    return PS_BAD_VALUE;
                count = utf8(code, bytes);
            }
            if (length + count >= room)
                return PS_TOO_LARGE;
            if (pass == 1)
                memcpy(text + length, bytes, count);
            length += count;
        }
    }
    text[length] = 0;
    return PS_OK;
}

/* What most properties are */

enum ps_code ps_get_number(const struct ps_property *property, struct ps_text *value)
{
    const struct ps_number *of = property->of;
    ps_put_number(value, *of->number, of->decimals);
    return PS_OK;
}

enum ps_code ps_set_number(const struct ps_property *property, const char *value)
{
    const struct ps_number *of = property->of;
    return ps_take_number(value, of->decimals, of->least, of->most, of->number);
}

enum ps_code ps_get_choice(const struct ps_property *property, struct ps_text *value)
{
    const struct ps_choice *of = property->of;
    ps_put(value, of->words[*of->word]);
    return PS_OK;
}

enum ps_code ps_set_choice(const struct ps_property *property, const char *value)
{
    const struct ps_choice *of = property->of;
    return ps_take_word(value, of->words, of->count, of->word);
}

enum ps_code ps_get_string(const struct ps_property *property, struct ps_text *value)
{
    const struct ps_string *of = property->of;
    ps_put_string(value, of->text);
    return PS_OK;
}

enum ps_code ps_set_string(const struct ps_property *property, const char *value)
{
    const struct ps_string *of = property->of;
    return ps_take_string(value, of->text, of->room);
}

/* Names */

/* Bring a name into its one spelling, in place. */
static enum ps_code canonical(char *name)
{
    char *to = name;
    uint8_t parts = 1;
    bool is_empty = true;
    for (; *name != 0; name++) {
        if (*name == '/')
            return PS_NO_SERVICE;
        if (*name == '.' && (is_empty || name[1] == 0))
            return PS_SYNTAX;
        if (*name == '.' && ++parts > 32)
            return PS_TOO_LARGE;
        is_empty = *name == '.';
        if (is_empty || is_free(*name)) {
            *to++ = *name;
            continue;
        }
        if (*name != '%' || hex_of(name[1]) < 0 || hex_of(name[2]) < 0)
            return PS_SYNTAX;
        *to = (char)(hex_of(name[1]) * 16 + hex_of(name[2]));
        if (!is_free(*to)) {
            char low = "0123456789ABCDEF"[(uint8_t)*to & 15];
            to[1] = "0123456789ABCDEF"[(uint8_t)*to >> 4];
            to[0] = '%';
            to[2] = low;
            to += 2;
        }
        to++;
        name += 2;
    }
    *to = 0;
    return parts == 1 && is_empty ? PS_SYNTAX : PS_OK;
}

/* Whether a name is below a place; the place "" has all below it. */
static const char *below(const char *name, const char *place)
{
    size_t length = strlen(place);
    if (length == 0)
        return name;
    return strncmp(name, place, length) == 0 && name[length] == '.' ? name + length + 1 : NULL;
}

static size_t first_part(const char *name)
{
    const char *dot = strchr(name, '.');
    return dot == NULL ? strlen(name) : (size_t)(dot - name);
}

static const struct ps_property *find(const struct ps *ps, const char *name)
{
    for (uint16_t i = 0; i < ps->count; i++)
        if (strcmp(ps->table[i].name, name) == 0)
            return &ps->table[i];
    return NULL;
}

static bool is_inner(const struct ps *ps, const char *name)
{
    for (uint16_t i = 0; i < ps->count; i++)
        if (below(ps->table[i].name, name) != NULL)
            return true;
    return false;
}

/* Whether a name is one that others can be below of, or that something can be asked about. */
static bool is_place(const struct ps *ps, const char *name)
{
    return *name == 0 || find(ps, name) != NULL || is_inner(ps, name);
}

/* Say the parts of names that come next below a place, each once; it is as long as it is. */
static void say_names(struct ps *ps, const char *place)
{
    bool is_first = true;
    say_char(ps, '(');
    for (uint16_t i = 0; i < ps->count; i++) {
        const char *name = below(ps->table[i].name, place);
        size_t length = name == NULL ? 0 : first_part(name);
        bool is_new = name != NULL;
        for (uint16_t j = 0; is_new && j < i; j++) {
            const char *other = below(ps->table[j].name, place);
            is_new = other == NULL || first_part(other) != length ||
                     strncmp(other, name, length) != 0;
        }
        if (!is_new)
            continue;
        if (!is_first)
            say_char(ps, ' ');
        is_first = false;
        while (length-- > 0)
            say_char(ps, *name++);
    }
    say_char(ps, ')');
}

/* Cut the extension off a name, if that is the last part of it. */
static bool has_extension(char *name, const char *extension)
{
    size_t length = strlen(name), of_extension = strlen(extension);
    if (length < of_extension || strcmp(name + length - of_extension, extension) != 0)
        return false;
    if (length == of_extension)
        *name = 0;
    else if (name[length - of_extension - 1] == '.')
        name[length - of_extension - 1] = 0;
    else
        return false;
    return true;
}

/* Parameters */

/* Take the next of k=v&k=v off; the value of one without "=" is "true". */
static bool next_parameter(char **rest, const char **key, const char **value)
{
    char *next, *equals;
    if (*rest == NULL)
        return false;
    *key = *rest;
    next = strchr(*rest, '&');
    if (next != NULL)
        *next++ = 0;
    equals = strchr(*rest, '=');
    if (equals != NULL)
        *equals++ = 0;
    *value = equals == NULL ? "true" : equals;
    *rest = next;
    return true;
}

static enum ps_code take_flag(const char *value, bool *flag)
{
    static const char *const WORDS[] = {"false", "true", "0", "1"};
    uint8_t word;
    if (ps_take_word(value, WORDS, 4, &word) != PS_OK)
        return PS_BAD_PARAMETER;
    *flag = (word & 1) != 0;
    return PS_OK;
}

static enum ps_code take_ms(const char *value, int32_t most, uint32_t *ms)
{
    int32_t number;
    if (ps_take_number(value, 3, 0, most, &number) != PS_OK)
        return PS_BAD_PARAMETER;
    *ms = (uint32_t)number;
    return PS_OK;
}

/* Listening */

static struct ps_listener *listener_of(struct ps *ps, uint16_t property)
{
    for (uint8_t i = 0; i < PS_LISTENERS; i++)
        if (ps->listeners[i].property == property)
            return &ps->listeners[i];
    return NULL;
}

static enum ps_code value_of(const struct ps_property *property, struct ps_text *value)
{
    enum ps_code code;
    memset(value, 0, sizeof *value);
    if (property->get == NULL)
        return PS_WRITE_ONLY;
    code = property->get(property, value);
    return code == PS_OK && value->is_full ? PS_TOO_LARGE : code;
}

static uint32_t hash_of(const struct ps_text *value)
{
    uint32_t hash = 2166136261u;
    for (uint8_t i = 0; i < value->length; i++)
        hash = (hash ^ (uint8_t)value->text[i]) * 16777619u;
    return hash;
}

static enum ps_code listen(struct ps *ps, const struct ps_property *property, const char *who,
                           char *parameters)
{
    uint16_t index = (uint16_t)(property - ps->table + 1);
    uint32_t every = PS_EVERY_MS, lease = PS_LEASE_MS;
    bool has_initial = true, is_removed = false;
    struct ps_listener *listener = listener_of(ps, index);
    struct ps_text value;
    const char *key, *given;
    enum ps_code code = value_of(property, &value);
    if (code != PS_OK)
        return code;
    while (code == PS_OK && next_parameter(&parameters, &key, &given)) {
        if (strcmp(key, "initial") == 0)
            code = take_flag(given, &has_initial);
        else if (strcmp(key, "remove") == 0)
            code = take_flag(given, &is_removed);
        else if (strcmp(key, "every") == 0)
            code = take_ms(given, 86400000, &every);
        else if (strcmp(key, "lease") == 0)
            code = take_ms(given, 86400000, &lease);
        else if (!(strcmp(key, "queue") == 0 && strcmp(given, "1") == 0) &&
                 !(strcmp(key, "mode") == 0 && strcmp(given, "change") == 0))
            code = PS_BAD_PARAMETER;
    }
    if (code != PS_OK)
        return code;
    if (strcmp(who, "self") != 0)
        return PS_DENIED;
    if (is_removed) {
        if (listener != NULL)
            listener->property = 0;
        return listener == NULL ? PS_UNKNOWN : PS_OK;
    }
    if (listener != NULL) {
        listener->is_told_again = true; /* the last event may have been lost */
    } else {
        listener = listener_of(ps, 0);
        if (listener == NULL)
            return PS_DENIED;
        listener->property = index;
        listener->is_told_again = has_initial;
        listener->seen = hash_of(&value);
        listener->revision = ++ps->revision;
    }
    listener->every = every < PS_EVERY_MS ? PS_EVERY_MS : every;
    listener->read_at = ps->now;
    listener->ends_at = ps->now + lease;
    listener->is_forever = lease == 0;
    return PS_OK;
}

static void tell(struct ps *ps, struct ps_listener *listener)
{
    const struct ps_property *property = &ps->table[listener->property - 1];
    struct ps_text value, revision;
    uint32_t hash;
    if (value_of(property, &value) != PS_OK)
        return;
    hash = hash_of(&value);
    if (hash == listener->seen && !listener->is_told_again)
        return;
    if (hash != listener->seen)
        listener->revision = ++ps->revision;
    listener->seen = hash;
    listener->is_told_again = false;
    memset(&revision, 0, sizeof revision);
    ps_put_number(&revision, listener->revision, 0);
    begin(ps, "");
    say(ps, "* ");
    say(ps, property->name);
    say(ps, ";rev=");
    say_text(ps, &revision);
    say_char(ps, ' ');
    say_text(ps, &value);
    end(ps);
}

void ps_poll(struct ps *ps, uint32_t now)
{
    ps->now = now;
    for (uint8_t i = 0; i < PS_LISTENERS; i++) {
        struct ps_listener *listener = &ps->listeners[i];
        if (listener->property == 0)
            continue;
        if (!listener->is_forever && (int32_t)(now - listener->ends_at) >= 0) {
            listener->property = 0;
        } else if ((int32_t)(now - listener->read_at) >= 0) {
            listener->read_at = now + listener->every;
            tell(ps, listener);
        }
    }
}

/* Requests */

static void answer_value(struct ps *ps, const char *id, const struct ps_property *property)
{
    struct ps_text value;
    enum ps_code code = value_of(property, &value);
    if (code != PS_OK || value.length == 0) {
        answer(ps, id, code);
        return;
    }
    begin(ps, id);
    say(ps, "= ");
    say_text(ps, &value);
    end(ps);
}

static void answer_names(struct ps *ps, const char *id, const char *place)
{
    begin(ps, id);
    say(ps, "= ");
    say_names(ps, place);
    end(ps);
}

static void get(struct ps *ps, const char *id, char *name, const char *parameters)
{
    const struct ps_property *property = find(ps, name);
    bool is_listen = property == NULL && has_extension(name, "listen");
    if (property == NULL && (has_extension(name, "properties") || is_listen || is_inner(ps, name))) {
        if (!is_place(ps, name))
            answer(ps, id, PS_UNKNOWN);
        else if (is_listen)
            answer(ps, id, PS_DENIED);
        else if (parameters != NULL)
            answer(ps, id, PS_BAD_PARAMETER);
        else
            answer_names(ps, id, name);
    } else if (property == NULL) {
        answer(ps, id, PS_UNKNOWN);
    } else if (parameters != NULL) {
        answer(ps, id, PS_BAD_PARAMETER);
    } else {
        answer_value(ps, id, property);
    }
}

/* Whether a name is a place, or asks for the names below one. */
static bool is_listed(const struct ps *ps, char *name)
{
    has_extension(name, "properties");
    return is_place(ps, name);
}

static enum ps_code take_echo(char *parameters, bool *has_echo)
{
    const char *key, *given;
    enum ps_code code = PS_OK;
    while (code == PS_OK && next_parameter(&parameters, &key, &given))
        code = strcmp(key, "echo") == 0 ? take_flag(given, has_echo) : PS_BAD_PARAMETER;
    return code;
}

static enum ps_code set_value(const struct ps_property *property, char *value, char *parameters,
                              bool *has_echo)
{
    enum ps_code code = take_echo(parameters, has_echo);
    if (code == PS_OK && property->set == NULL)
        code = PS_READ_ONLY;
    if (code == PS_OK)
        code = item(&value);
    return code == PS_OK ? property->set(property, value) : code;
}

static void set(struct ps *ps, const char *id, char *name, char *value, char *parameters,
                uint16_t line)
{
    const struct ps_property *property = find(ps, name);
    bool has_echo = false;
    enum ps_code code;
    if (*id != 0 && line == ps->last_line && strcmp(id, ps->last_id) == 0) {
        /* Asked again, since the reply was lost: it acts once. */
        code = (enum ps_code)ps->last_code;
        take_echo(parameters, &has_echo);
    } else if (property != NULL) {
        code = set_value(property, value, parameters, &has_echo);
    } else if (has_extension(name, "listen")) {
        property = find(ps, name);
        if (property != NULL) /* where others speak, too, nobody speaks unasked */
            code = ps->address == NULL ? listen(ps, property, value, parameters) : PS_DENIED;
        else /* to names nobody can listen here */
            code = is_listed(ps, name) ? PS_DENIED : PS_UNKNOWN;
    } else {
        code = is_listed(ps, name) ? PS_READ_ONLY : PS_UNKNOWN;
    }
    if (*id != 0 && code != PS_BUSY) { /* asked again, it may be well */
        strcpy(ps->last_id, id);
        ps->last_line = line;
        ps->last_code = (uint8_t)code;
    }
    if (code == PS_OK && has_echo && property != NULL)
        answer_value(ps, id, property);
    else
        answer(ps, id, code);
}

/* Take note of bytes that are announced, which are no requests; return whether they are. */
static bool announces_bytes(struct ps *ps, const char *value)
{
    uint32_t count = 0;
    if (*value++ != '{' || !is_digit(*value))
        return false;
    for (; is_digit(*value); value++)
        count = count > 100000000u ? count : count * 10 + (uint32_t)(*value - '0');
    if (*value++ != '}' || (*value != 0 && *value != '\n'))
        return false;
    if (*value == 0 && ps->address == NULL) /* on a shared line bytes need a check */
        ps->skipped = count + 1;
    return true;
}

static void perform(struct ps *ps, char *line, uint16_t check)
{
    char *id = line + strlen(line), *name, *value = NULL, *parameters;
    bool is_get, is_id;
    enum ps_code code;
    if (*line == '#') {
        id = ++line;
        line = strchr(line, ' ');
        is_id = line != NULL && line != id && line - id <= PS_ID_BYTES;
        for (const char *at = id; is_id && at != line; at++)
            is_id = (uint8_t)*at > ' ';
        if (!is_id) {
            answer(ps, "", PS_SYNTAX);
            return;
        }
        *line++ = 0;
    }
    is_get = strncmp(line, "GET ", 4) == 0;
    if (!is_get && strncmp(line, "SET ", 4) != 0) {
        answer(ps, id, PS_SYNTAX);
        return;
    }
    name = line + 4;
    if (is_get) {
        char *last = name + strlen(name);
        while (last != name && last[-1] == ' ')
            *--last = 0;
        while (*name == ' ')
            name++;
    } else {
        value = strchr(name, ' ');
        if (value != NULL)
            *value++ = 0;
        else
            value = name + strlen(name);
        if (announces_bytes(ps, value)) {
            answer(ps, id, PS_TOO_LARGE);
            return;
        }
    }
    parameters = strchr(name, '?');
    if (parameters != NULL)
        *parameters++ = 0;
    code = canonical(name);
    if (code != PS_OK)
        answer(ps, id, code);
    else if (is_get)
        get(ps, id, name, parameters);
    else
        set(ps, id, name, value, parameters, check);
}

/* Cut the check off a line and undo what protects its bytes; return whether it has a check. */
static bool has_check(struct ps *ps, bool *is_right, uint16_t *check)
{
    char *line = ps->line, *tail, *to = line;
    uint16_t given = 0;
    *check = 0xFFFF;
    if (ps->length < 6)
        return false;
    tail = line + ps->length - 6;
    if (tail[0] != ' ' || tail[1] != '~')
        return false;
    for (uint8_t i = 2; i < 6; i++) {
        if (hex_of(tail[i]) < 0)
            return false;
        given = (uint16_t)(given * 16 + hex_of(tail[i]));
    }
    for (const char *at = line; at != tail; at++)
        *check = checked(*check, *at);
    *is_right = given == *check;
    if (!*is_right)
        return true;
    for (const char *at = line; at != tail; at++)
        *to++ = *at == DLE && at + 1 != tail ? (char)(*++at ^ 0x40) : *at;
    *to = 0;
    ps->length = (uint8_t)(to - line);
    return true;
}

/* Cut the address off a line that has ended; return whether this device is meant. */
static bool is_meant(struct ps *ps, char **line)
{
    size_t length;
    ps->line[ps->length] = 0;
    if (ps->address == NULL)
        return true;
    if (*(*line)++ != '@')
        return false;
    ps->is_mute = strncmp(*line, ALL, sizeof ALL - 1) == 0 && (*line)[sizeof ALL - 1] == ' ';
    length = ps->is_mute ? sizeof ALL - 1 : strlen(ps->address);
    if (!ps->is_mute && (strncmp(*line, ps->address, length) != 0 || (*line)[length] != ' '))
        return false;
    *line += length + 1;
    return true;
}

static void take_line(struct ps *ps, char *line)
{
    bool is_right = false;
    uint16_t check;
    if (has_check(ps, &is_right, &check)) {
        if (is_right)
            ps->has_checks = true;
    } else if (!ps->has_checks || strcmp(line, HELLO) == 0) {
        ps->has_checks = false;
        is_right = true;
        for (uint8_t i = 0; i < ps->length; i++)
            check = checked(check, ps->line[i]);
    }
    if (!is_right && ps->address == NULL)
        answer(ps, "", PS_CHECKSUM);
    else if (is_right && memchr(ps->line, 0, ps->length) != NULL)
        answer(ps, "", PS_SYNTAX);
    else if (is_right)
        perform(ps, line, check);
}

void ps_take(struct ps *ps, char byte)
{
    char *line = ps->line;
    if (ps->skipped != 0 && ps->now - ps->taken_at < QUIET_MS) {
        ps->skipped--;
        ps->taken_at = ps->now;
        return;
    }
    ps->skipped = 0;
    ps->taken_at = ps->now;
    if (byte != '\n') {
        if (ps->length == PS_LINE_BYTES)
            ps->is_too_long = true;
        else
            ps->line[ps->length++] = byte;
        return;
    }
    if (!ps->is_too_long && ps->length != 0 && ps->line[ps->length - 1] == '\r')
        ps->length--;
    if (ps->length != 0 && is_meant(ps, &line)) {
        if (ps->is_too_long)
            answer(ps, "", PS_TOO_LARGE);
        else
            take_line(ps, line);
    }
    ps->is_mute = ps->is_too_long = false;
    ps->length = 0;
}

void ps_init(struct ps *ps, const struct ps_property *table, uint16_t count, ps_sender send,
             void *context)
{
    memset(ps, 0, sizeof *ps);
    ps->table = table;
    ps->count = count;
    ps->send = send;
    ps->context = context;
}

void ps_share(struct ps *ps, const char *address) { ps->address = address; }
