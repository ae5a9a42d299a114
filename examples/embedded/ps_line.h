/* Live properties of a small device over a serial line: the line protocol of the Property Service.

   C99; no heap, no stdio, of the library only <string.h>. One table of properties, one struct of
   state, two calls: ps_take() for each byte that came, ps_poll() now and then. See README.md. */

#ifndef PS_LINE_H
#define PS_LINE_H

#include <stdbool.h>
#include <stddef.h>
#include <stdint.h>

#ifndef PS_LINE_BYTES
#define PS_LINE_BYTES 128 /* longest line that is taken, its end not counted */
#endif
#ifndef PS_VALUE_BYTES
#define PS_VALUE_BYTES 80 /* longest value that is sent */
#endif
#ifndef PS_ID_BYTES
#define PS_ID_BYTES 12 /* longest id of a request */
#endif
#ifndef PS_LISTENERS
#define PS_LISTENERS 4 /* properties that are listened to at a time */
#endif
#ifndef PS_EVERY_MS
#define PS_EVERY_MS 20 /* how often one that is listened to is read */
#endif
#ifndef PS_LEASE_MS
#define PS_LEASE_MS 10000 /* how long, unless the listener says otherwise */
#endif

#if PS_LINE_BYTES < 32 || PS_LINE_BYTES > 255
#error "PS_LINE_BYTES is 32 to 255"
#endif
#if PS_VALUE_BYTES < 8 || PS_VALUE_BYTES > 255
#error "PS_VALUE_BYTES is 8 to 255"
#endif
#if PS_ID_BYTES < 1 || PS_ID_BYTES > PS_LINE_BYTES
#error "PS_ID_BYTES is 1 to PS_LINE_BYTES"
#endif
#if PS_LISTENERS < 1 || PS_LISTENERS > 255
#error "PS_LISTENERS is 1 to 255"
#endif

/* What a request comes to. */
enum ps_code {
    PS_OK,
    PS_UNKNOWN,
    PS_NO_SERVICE,
    PS_READ_ONLY,
    PS_WRITE_ONLY,
    PS_DENIED,
    PS_SYNTAX,
    PS_BAD_VALUE,
    PS_BAD_PARAMETER,
    PS_BUSY,
    PS_TOO_LARGE,
    PS_CHECKSUM,
    PS_INTERNAL
};

/* A value that is being written. What does not fit is not sent at all, but answered too-large. */
struct ps_text {
    char text[PS_VALUE_BYTES];
    uint8_t length;
    bool is_full;
};

struct ps_property;
typedef enum ps_code (*ps_getter)(const struct ps_property *property, struct ps_text *value);
typedef enum ps_code (*ps_setter)(const struct ps_property *property, const char *value);

/* A property: no getter makes it write-only, no setter read-only. Tables of them are constant. */
struct ps_property {
    const char *name; /* segments joined by dots */
    ps_getter get;
    ps_setter set;  /* the value is one item of the grammar, blanks around it cut off */
    const void *of; /* for getter and setter */
};

struct ps_listener {
    uint32_t seen;    /* hash of the value last sent */
    uint32_t read_at; /* [ms] */
    uint32_t ends_at; /* [ms] */
    uint32_t every;   /* [ms] */
    uint16_t revision;
    uint16_t property; /* index, one more; 0: free */
    bool is_forever;
    bool is_told_again;
};

/* Where bytes go; it may wait until there is room. */
typedef void (*ps_sender)(void *context, char byte);

struct ps {
    const struct ps_property *table;
    uint16_t count;
    ps_sender send;
    void *context;
    const char *address; /* NULL: alone on its line */
    uint32_t now;      /* [ms] */
    uint32_t taken_at; /* [ms] */
    uint32_t skipped;  /* bytes still to be thrown away */
    uint16_t check;
    uint16_t revision;
    uint16_t last_line; /* check of the last SET that had an id */
    uint8_t last_code;
    bool has_checks;
    bool is_mute; /* all are meant, and nobody answers */
    bool is_too_long;
    uint8_t length;
    char line[PS_LINE_BYTES + 1];
    char last_id[PS_ID_BYTES + 1];
    struct ps_listener listeners[PS_LISTENERS];
};

void ps_init(struct ps *ps, const struct ps_property *table, uint16_t count, ps_sender send,
             void *context);

/* Share the line with others (RS-485, radio): only lines that begin with "@ADDRESS " or "@all " are
   taken, replies begin with "@ADDRESS: ", nothing is said unasked. Letters, digits and _. */
void ps_share(struct ps *ps, const char *address);

/* Take a byte that came; requests are answered in here. Not for interrupt handlers. */
void ps_take(struct ps *ps, char byte);

/* Tell those who listen what has changed. `now` counts milliseconds and may run over. */
void ps_poll(struct ps *ps, uint32_t now);

/* Writing values. */
void ps_put(struct ps_text *value, const char *text);
void ps_put_number(struct ps_text *value, int32_t number, uint8_t decimals);
void ps_put_string(struct ps_text *value, const char *text); /* in quotes */

/* Reading values: PS_BAD_VALUE if it is another type, or out of range. */
enum ps_code ps_take_number(const char *value, uint8_t decimals, int32_t least, int32_t most,
                            int32_t *number);
enum ps_code ps_take_word(const char *value, const char *const *words, uint8_t count,
                          uint8_t *word);
enum ps_code ps_take_string(const char *value, char *text, size_t room);

/* Getters and setters of what most properties are; `of` points to one of these. */

struct ps_number { /* 1234 with 3 decimals is 1.234 */
    int32_t *number;
    int32_t least, most;
    uint8_t decimals;
};
enum ps_code ps_get_number(const struct ps_property *property, struct ps_text *value);
enum ps_code ps_set_number(const struct ps_property *property, const char *value);

struct ps_choice { /* one of some words; {"false", "true"} is a boolean */
    uint8_t *word;
    const char *const *words;
    uint8_t count;
};
enum ps_code ps_get_choice(const struct ps_property *property, struct ps_text *value);
enum ps_code ps_set_choice(const struct ps_property *property, const char *value);

struct ps_string {
    char *text;
    size_t room; /* with the 0 at its end */
};
enum ps_code ps_get_string(const struct ps_property *property, struct ps_text *value);
enum ps_code ps_set_string(const struct ps_property *property, const char *value);

#endif
