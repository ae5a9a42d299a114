/* Rubbish for the line protocol: fuzzer SEED LINES. Built with sanitizers, it ends at what they find.

   Lines are made of what requests are made of, then damaged. Each line that is not empty has to be
   answered by exactly one line of printable characters; by a device that shares its line, only what
   is sent to its address, by at most one line. */

#include "ps_line.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

static uint32_t state;
static struct ps alone, shared;
static char said[4096];
static size_t length, replies;

static uint32_t chance(uint32_t below)
{
    state ^= state << 13;
    state ^= state >> 17;
    state ^= state << 5;
    return state % below;
}

static void fail(const char *why, const char *line, size_t of_line)
{
    fprintf(stderr, "%s\nasked: ", why);
    for (size_t i = 0; i < of_line; i++)
        fprintf(stderr, line[i] >= ' ' && line[i] < 127 ? "%c" : "\\x%02x", (uint8_t)line[i]);
    fprintf(stderr, "\nsaid: %.*s\n", (int)length, said);
    exit(1);
}

static void hear(void *context, char byte)
{
    (void)context;
    if (length == sizeof said)
        fail("it does not end", "", 0);
    said[length++] = byte;
    if (byte == '\n')
        replies++;
    else if ((uint8_t)byte < ' ')
        fail("not printable", "", 0);
}

/* A device with a property of each kind. */

static int32_t number, fixed;
static uint8_t word;
static char text[20] = "text";
static const char *const WORDS[] = {"idle", "drive", "false"};
static const struct ps_number NUMBER = {&number, -100, 100, 0}, FIXED = {&fixed, INT32_MIN, INT32_MAX, 6};
static const struct ps_choice CHOICE = {&word, WORDS, 3};
static const struct ps_string STRING = {text, sizeof text};

static enum ps_code get_long(const struct ps_property *property, struct ps_text *value)
{
    (void)property;
    for (uint32_t i = chance(2 * PS_VALUE_BYTES); i > 0; i--)
        ps_put(value, chance(2) ? "\n" : "x");
    return PS_OK;
}

static enum ps_code get_failing(const struct ps_property *property, struct ps_text *value)
{
    ps_put(value, property->name);
    return (enum ps_code)chance(PS_INTERNAL + 1);
}

static enum ps_code set_failing(const struct ps_property *property, const char *value)
{
    (void)property;
    return (enum ps_code)(strlen(value) % (PS_INTERNAL + 1));
}

static const struct ps_property TABLE[] = {
    {"n", ps_get_number, ps_set_number, &NUMBER},
    {"a.b.fixed", ps_get_number, ps_set_number, &FIXED},
    {"a.b.mode", ps_get_choice, ps_set_choice, &CHOICE},
    {"a.text", ps_get_string, ps_set_string, &STRING},
    {"a%20b", get_long, NULL, NULL},
    {"fails", get_failing, set_failing, NULL},
    {"code", NULL, set_failing, NULL},
};

/* Lines */

static const char *const STARTS[] = {"SET ", "SET ", "GET ", "#1 SET ", "#abcdefghijkl GET ", "#"};
static const char *const PREFIXES[] = {"", "", "", "@7 ", "@7 ", "@7 ", "@all ", "@8 ", "@77 ", "@7: ", "@"};
static const char *const NAMES[] = {"n", "a.b.fixed", "a.b.mode", "a.text", "a%20b", "%61%20b", "a",
                                    "fails", "code", "n.listen", "a.text.listen", "fails.listen",
                                    "a.properties", "properties", "a..b", "%4", "%ff", "x/y", ""};
static const char *const GIVEN[] = {"", "", "", "?echo", "?echo=0", "?lease=3&every=0.01", "?remove",
                                    "?initial=0&queue=1", "?mode=change&", "?=", "?x=1", "?lease=1e9"};
static const char *const VALUES[] = {
    "self", "self", "0", "1", "-0.5", "+1.250", "1e9", "1e-9", "-100", "1e999", "99999999999999999999",
    ".5", "5.", "-", "idle", "drive", "true", "inf", "\"a \\u{e9}\\n\\\"\"", "\"\\u{d800}\"",
    "\"\\u{10FFFF}\"", "\"twenty characters and more\"", "\"", "\"\\", "(", ")", "((1) (2 \"x\"))",
    "(((((1)))))", "<a/>", "{5}", "{4294967295}", "{", " ", "\t", "\x10J", "\x10@", "\r", "\xff\xfe",
    " ~", " ~29B1", "",
};

#define ANY_OF(words) words[chance(sizeof words / sizeof words[0])]

static size_t added(char *line, size_t size, size_t room, const char *part)
{
    if (size + strlen(part) >= room)
        return size;
    memcpy(line + size, part, strlen(part));
    return size + strlen(part);
}

static size_t made(char *line, size_t room)
{
    size_t size = added(line, 0, room, ANY_OF(PREFIXES));
    size = added(line, size, room, ANY_OF(STARTS));
    size = added(line, size, room, ANY_OF(NAMES));
    size = added(line, size, room, ANY_OF(GIVEN));
    size = added(line, size, room, " ");
    for (uint32_t parts = chance(4) ? 1 : chance(chance(8) ? 7 : 60); parts > 0; parts--)
        size = added(line, size, room, ANY_OF(VALUES));
    if (chance(8) == 0)
        size = chance((uint32_t)size + 1);
    while (size != 0 && chance(4) == 0) {
        line[chance((uint32_t)size)] = (char)chance(256);
    }
    for (size_t i = 0; i < size; i++)
        if (line[i] == '\n')
            line[i] = '_';
    if (chance(2)) {
        uint16_t check = 0xFFFF;
        for (size_t i = 0; i < size; i++)
            for (int bit = 7; bit >= 0; bit--) {
                bool is_set = ((check >> 15) ^ ((uint8_t)line[i] >> bit)) & 1;
                check = (uint16_t)((uint16_t)(check << 1) ^ (is_set ? 0x1021u : 0u));
            }
        size += (size_t)sprintf(line + size, " ~%04X", check);
    }
    return size;
}

static void feed(struct ps *ps, const char *line, size_t size)
{
    replies = length = 0;
    for (size_t at = 0; at < size; at++)
        ps_take(ps, line[at]);
    ps_take(ps, '\n');
}

static void check_shared(const char *line, size_t size)
{
    feed(&shared, line, size);
    if (replies > (size >= 3 && memcmp(line, "@7 ", 3) == 0 ? 1u : 0u))
        fail("answered, or too often", line, size);
    if (replies == 1 && memcmp(said, "@7: ", 4) != 0)
        fail("by nobody", line, size);
}

int main(int argc, char **argv)
{
    uint32_t lines = argc > 2 ? (uint32_t)strtoul(argv[2], NULL, 10) : 20000, now = UINT32_MAX - 9999;
    uint32_t of_shared = 0;
    state = argc > 1 ? (uint32_t)strtoul(argv[1], NULL, 10) : 1;
    state = state == 0 ? 1 : state;
    ps_init(&alone, TABLE, sizeof TABLE / sizeof TABLE[0], hear, NULL);
    ps_init(&shared, TABLE, sizeof TABLE / sizeof TABLE[0], hear, NULL);
    ps_share(&shared, "7");
    for (uint32_t i = 0; i < lines; i++) {
        static char line[320];
        static size_t size;
        if (i == 0 || chance(8)) /* else the same once more */
            size = made(line, sizeof line - 8);
        if (chance(40) == 0)
            alone.has_checks = shared.has_checks = false;
        bool is_empty = size == 0 || (size == 1 && line[0] == '\r');
        check_shared(line, size);
        of_shared += (uint32_t)replies;
        feed(&alone, line, size);
        if (replies != (is_empty ? 0u : 1u))
            fail("not answered once", line, size);
        length = 0;
        now += chance(50);
        for (size_t at = 0; at < 100 && alone.skipped != 0; at++)
            ps_take(&alone, line[at]);
        now += alone.skipped != 0 ? 1000 : 0; /* a silence ends what is thrown away */
        ps_poll(&alone, now);
        replies = 0;
        ps_poll(&shared, now);
        if (replies != 0)
            fail("said unasked", line, size);
        if (number < -100 || number > 100 || word > 2 || strlen(text) >= sizeof text)
            fail("out of range", line, size);
    }
    if (lines > 1000 && of_shared < lines / 10)
        fail("the shared one hardly answered", "", 0);
    printf("%u lines answered\n", (unsigned)lines);
    return 0;
}
