/* audit_lines.h - a line of a mission as records (docs/audit.md), part of audit.c.
 *
 * It reads less than JSON, and what it reads exactly as exover/audit/mission.py does; whatever else is odd. Odd are all faults,
 * escapes, integers of more than 18 digits, and what does not fit. Bound: three looks at every byte, and a nesting of 8.
 */
#ifndef AUDIT_LINES_H
#define AUDIT_LINES_H

enum key { K_EVENT, K_ASK, K_REPORT, K_OBSERVE, K_ABORT, K_LAUNCH, K_KILL, K_WAIT, K_REJECT, K_ACTIONS, K_REFUSED, K_ALARM,
           K_LOST, K_INVALID, K_ARGS, K_RESULTS, K_OUTCOME, K_STATUS, K_VALUE, K_INSTANCE, K_WAITING, K_TIME, KEYS };
static const name KEY[KEYS] = {
    {"event", 5}, {"ask", 3}, {"report", 6}, {"observe", 7}, {"abort", 5}, {"launch", 6}, {"kill", 4}, {"wait", 4},
    {"reject", 6}, {"actions", 7}, {"refused", 7}, {"alarm", 5}, {"lost", 4}, {"invalid", 7}, {"args", 4},
    {"results", 7}, {"outcome", 7}, {"status", 6}, {"value", 5}, {"instance", 8}, {"waiting", 7}, {"time", 4}};

typedef struct text {
    const char *at, *end;
} text;

typedef struct object { /* the values of the keys that it has, the last of each; NULL of others */
    text of[KEYS];
} object;

typedef struct out {
    unsigned char *at, *end;
} out;

static bool is_called(name n, const char *at, size_t size)
{
    return n.size == size && memcmp(n.text, at, size) == 0;
}

static uint32_t hash_of(const char *at, size_t size, bool observable)
{
    uint32_t hash = observable ? 2166136261u ^ 77u : 2166136261u; /* FNV-1a (Fowler, Noll, Vo 1991) */
    for (size_t i = 0; i < size; i++)
        hash = (hash ^ (unsigned char)at[i]) * 16777619u;
    return hash;
}

/* Enter a name, of an observable or a request, into the table. */
static void enter(audit *a, name n, int32_t number, bool observable)
{
    uint32_t at = hash_of(n.text, n.size, observable) & a->mask;
    while (a->slots_of_names[2 * at] != 0)
        at = (at + 1) & a->mask;
    a->slots_of_names[2 * at] = observable ? 2 : 1;
    a->slots_of_names[2 * at + 1] = number;
}

static int32_t find(const audit *a, const char *from, size_t size, bool observable)
{
    for (uint32_t at = hash_of(from, size, observable) & a->mask; a->slots_of_names[2 * at] != 0; at = (at + 1) & a->mask) {
        const int32_t number = a->slots_of_names[2 * at + 1];
        const name known = observable ? a->observables[number < a->observable_count ? number : 0].name : a->requests[number].name;
        if (a->slots_of_names[2 * at] == (observable ? 2 : 1) && is_called(known, from, size))
            return number;
    }
    return NOBODY;
}

/* ---- JSON ---- */

static void skip_blanks(text *t)
{
    while (t->at < t->end && (*t->at == ' ' || *t->at == '\t' || *t->at == '\r'))
        t->at++;
}

static bool takes(text *t, char c)
{
    if (t->at < t->end && *t->at == c) {
        t->at++;
        return true;
    }
    return false;
}

/* Pass one character of UTF-8 that is not ASCII. */
static bool skip_wide(text *t)
{
    const unsigned char *c = (const unsigned char *)t->at;
    const size_t left = (size_t)(t->end - t->at);
    const int more = c[0] >= 0xc2 && c[0] <= 0xdf ? 1 : c[0] >= 0xe0 && c[0] <= 0xef ? 2 : c[0] >= 0xf0 && c[0] <= 0xf4 ? 3 : 0;
    if (more == 0 || left <= (size_t)more)
        return false;
    for (int i = 1; i <= more; i++) {
        if ((c[i] & 0xc0) != 0x80)
            return false;
    }
    t->at += more + 1;
    return !(c[0] == 0xe0 && c[1] < 0xa0) && !(c[0] == 0xed && c[1] > 0x9f) && !(c[0] == 0xf0 && c[1] < 0x90)
           && !(c[0] == 0xf4 && c[1] > 0x8f);
}

/* Read a string without escapes; `found` is what stands between the quotes. */
static bool read_string(text *t, text *found)
{
    if (!takes(t, '"'))
        return false;
    found->at = t->at;
    while (t->at < t->end && *t->at != '"') {
        const unsigned char c = (unsigned char)*t->at;
        if (c == '\\' || c < 0x20)
            return false;
        if (c < 0x80)
            t->at++;
        else if (!skip_wide(t))
            return false;
    }
    found->end = t->at;
    return takes(t, '"');
}

static bool skip_digits(text *t)
{
    const char *from = t->at;
    while (t->at < t->end && *t->at >= '0' && *t->at <= '9')
        t->at++;
    return t->at > from;
}

static bool skip_number(text *t)
{
    (void)takes(t, '-');
    if (!takes(t, '0') && !skip_digits(t))
        return false;
    if (takes(t, '.') && !skip_digits(t))
        return false;
    if (takes(t, 'e') || takes(t, 'E')) {
        (void)(takes(t, '+') || takes(t, '-'));
        return skip_digits(t);
    }
    return true;
}

static bool skip_word(text *t, const char *word)
{
    const size_t size = strlen(word);
    if ((size_t)(t->end - t->at) < size || memcmp(t->at, word, size) != 0)
        return false;
    t->at += size;
    return true;
}

/* Pass a value. A number that 0 is written before, as 01, is found out by what stands behind the 0. */
static bool skip_value(text *t, int depth)
{
    text ignored;
    if (t->at >= t->end || depth == 0)
        return false;
    switch (*t->at) {
    case '"': return read_string(t, &ignored);
    case 't': return skip_word(t, "true");
    case 'f': return skip_word(t, "false");
    case 'n': return skip_word(t, "null");
    case '{':
    case '[': {
        const bool named = *t->at++ == '{';
        const char closing = named ? '}' : ']';
        skip_blanks(t);
        if (takes(t, closing))
            return true;
        do {
            skip_blanks(t);
            if (named && !read_string(t, &ignored))
                return false;
            skip_blanks(t);
            if (named && !takes(t, ':'))
                return false;
            skip_blanks(t);
            if (!skip_value(t, depth - 1))
                return false;
            skip_blanks(t);
        } while (takes(t, ','));
        return takes(t, closing);
    }
    default: return skip_number(t);
    }
}

/* The next member of an object, or element of a list, of which `t` is what stands behind its opening bracket: 1; at the end 0; if
 * it is odd, -1. */
static int next_part(text *t, bool *first, char closing, text *key, text *value)
{
    skip_blanks(t);
    if (takes(t, closing))
        return *first ? 0 : -1;
    if (key != NULL) {
        if (!read_string(t, key))
            return -1;
        skip_blanks(t);
        if (!takes(t, ':'))
            return -1;
    }
    skip_blanks(t);
    value->at = t->at;
    if (!skip_value(t, 8))
        return -1;
    value->end = t->at;
    skip_blanks(t);
    *first = false;
    return 1;
}

/* After a part: 1 if another follows, 0 at the end, else -1. */
static int behind_part(text *t, char closing)
{
    if (takes(t, ',')) {
        skip_blanks(t);
        return t->at < t->end && *t->at != closing ? 1 : -1;
    }
    return takes(t, closing) ? 0 : -1;
}

static int key_of(const text *found)
{
    for (int k = 0; k < KEYS; k++) {
        if (is_called(KEY[k], found->at, (size_t)(found->end - found->at)))
            return k;
    }
    return KEYS;
}

/* Read an object that begins at `t`; false if it is none, or odd. */
static bool read_object(text *t, object *o)
{
    text key, value;
    bool first = true;
    for (int k = 0; k < KEYS; k++)
        o->of[k].at = NULL;
    if (!takes(t, '{'))
        return false;
    int more = 1;
    while (more == 1) {
        const int found = next_part(t, &first, '}', &key, &value);
        if (found <= 0)
            return found == 0;
        const int k = key_of(&key);
        if (k < KEYS)
            o->of[k] = value;
        more = behind_part(t, '}');
    }
    return more == 0;
}

static bool has(const object *o, enum key k)
{
    return o->of[k].at != NULL;
}

static bool read_plain(const object *o, enum key k, text *found)
{
    text t = o->of[k];
    return t.at != NULL && read_string(&t, found);
}

/* ---- values ---- */

static bool read_integer(text t, int64_t *value)
{
    const bool negative = takes(&t, '-');
    if (t.at >= t.end || t.end - t.at > 18)
        return false;
    int64_t read = 0;
    for (; t.at < t.end; t.at++) {
        if (*t.at < '0' || *t.at > '9')
            return false;
        read = 10 * read + (*t.at - '0');
    }
    *value = negative ? -read : read;
    return true;
}

/* The double nearest to a number. Up to 2^53 times or over a power of ten that is a double too, one operation rounds right
 * (Clinger, 1990); others are left to the C library, whose decimal sign is a point unless somebody has changed it. */
static bool read_real(text t, double *value)
{
    static const double TENS[] = {1e0,  1e1,  1e2,  1e3,  1e4,  1e5,  1e6,  1e7,  1e8,  1e9,  1e10, 1e11,
                                  1e12, 1e13, 1e14, 1e15, 1e16, 1e17, 1e18, 1e19, 1e20, 1e21, 1e22};
    const text whole = t;
    const bool negative = takes(&t, '-');
    uint64_t digits = 0;
    int scale = 0, count = 0;
    bool fraction = false, exponent = false;
    if (t.at >= t.end || *t.at < '0' || *t.at > '9')
        return false;
    for (; t.at < t.end && !exponent; t.at++) {
        if (*t.at == '.') {
            fraction = true;
        } else if (*t.at == 'e' || *t.at == 'E') {
            exponent = true;
        } else {
            digits = 10 * digits + (uint64_t)(*t.at - '0');
            scale -= fraction;
            count += digits != 0;
            if (count > 19)
                break;
        }
    }
    if (exponent || count > 18 || digits > UINT64_C(1) << 53 || scale < -22 || FLT_EVAL_METHOD != 0) {
        char copy[64], *behind;
        const size_t size = (size_t)(whole.end - whole.at);
        if (size >= sizeof copy)
            return false;
        memcpy(copy, whole.at, size);
        copy[size] = '\0';
        *value = strtod(copy, &behind);
        if (behind != copy + size || !isfinite(*value))
            return false;
    } else {
        *value = (double)digits / TENS[-scale];
        *value = negative ? -*value : *value;
    }
    *value += 0.0; /* -0.0 becomes 0.0 */
    return true;
}

static bool read_value(const param *p, text t, exover_value *value)
{
    text plain;
    switch (p->kind) {
    case 0:
        value->integer = *t.at == 't';
        return *t.at == 't' || *t.at == 'f';
    case 1: return read_integer(t, &value->integer);
    case 2: return read_real(t, &value->real);
    default:
        if (!read_string(&t, &plain))
            return false;
        for (int64_t k = 0; k <= p->high; k++) {
            if (is_called(p->values[k], plain.at, (size_t)(plain.end - plain.at))) {
                value->integer = k;
                return true;
            }
        }
        return false;
    }
}

static bool is_in_range(const param *p, const exover_value *value)
{
    return p->kind == 2 ? value->real >= p->least && value->real <= p->most : value->integer >= p->low && value->integer <= p->high;
}

/* Write the values of an object, all that there are to be; without it there are to be none. */
static bool write_values(out *o, const param *params, int32_t count, text t)
{
    text key, value;
    uint64_t seen[4] = {0};
    bool first = true;
    int32_t there = 0;
    if (t.at == NULL)
        return count == 0;
    if (!takes(&t, '{') || count > 256 || o->end - o->at < 8 * count)
        return false;
    for (int more = 1; more == 1; more = behind_part(&t, '}')) {
        const int found = next_part(&t, &first, '}', &key, &value);
        if (found <= 0)
            break;
        int32_t k = there < count ? there : 0;
        const size_t size = (size_t)(key.end - key.at);
        if (count == 0)
            return false;
        if (!is_called(params[k].name, key.at, size)) {
            for (k = 0; k < count && !is_called(params[k].name, key.at, size); k++)
                ;
            if (k == count)
                return false;
        }
        exover_value read;
        if (!read_value(&params[k], value, &read) || !is_in_range(&params[k], &read))
            return false;
        memcpy(o->at + 8 * k, &read.bits, 8);
        there += (seen[k / 64] >> k % 64 & 1) == 0;
        seen[k / 64] |= UINT64_C(1) << k % 64;
    }
    o->at += 8 * count;
    return there == count;
}

/* ---- records ---- */

static void put(out *o, uint32_t number, int bytes)
{
    for (; bytes > 0; bytes--, number >>= 8)
        *o->at++ = (unsigned char)(number & 255);
}

/* Begin a record, whose length is written by `close`; NULL if there is no room. */
static unsigned char *open_record(out *o, int kind)
{
    if (o->end - o->at < 24)
        return NULL;
    unsigned char *from = o->at;
    o->at += 4;
    put(o, (uint32_t)kind, 1);
    return from;
}

static bool close_record(out *o, unsigned char *from)
{
    const out length = {from, from + 4};
    out head = length;
    put(&head, (uint32_t)(o->at - from - 4), 4);
    return true;
}

static const request *named(const audit *a, const object *o, enum key k, uint32_t *number)
{
    text plain;
    if (!read_plain(o, k, &plain))
        return NULL;
    const int32_t found = find(a, plain.at, (size_t)(plain.end - plain.at), false);
    *number = (uint32_t)found;
    return found == NOBODY ? NULL : &a->requests[found];
}

static bool read_instance(const object *o, const request *r, uint32_t *instance)
{
    int64_t read = 0;
    if (has(o, K_INSTANCE) && (!read_integer(o->of[K_INSTANCE], &read) || read < 0 || read >= r->instances))
        return false;
    *instance = (uint32_t)read;
    return true;
}

static bool write_report(const request *r, const object *o, uint32_t number, out *to)
{
    text outcome, plain;
    uint32_t instance, status = 0xffff;
    unsigned char *from = open_record(to, REPORT);
    if (from == NULL || !read_instance(o, r, &instance) || !read_plain(o, K_OUTCOME, &outcome))
        return false;
    const size_t size = (size_t)(outcome.end - outcome.at);
    const int kind = is_called((name){"ok", 2}, outcome.at, size)            ? 0
                     : is_called((name){"failed", 6}, outcome.at, size)      ? 1
                     : is_called((name){"interrupted", 11}, outcome.at, size) ? 2
                                                                              : 3;
    if (kind == 3)
        return false;
    if (kind == 1 && has(o, K_STATUS)) {
        if (!read_plain(o, K_STATUS, &plain))
            return false;
        for (status = 0; status < (uint32_t)r->statuses; status++) {
            if (is_called(r->status[status], plain.at, (size_t)(plain.end - plain.at)))
                break;
        }
        if (status == (uint32_t)r->statuses)
            return false;
    }
    put(to, number, 2);
    put(to, instance, 2);
    put(to, (uint32_t)kind, 1);
    put(to, status, 2);
    return (kind != 0 || write_values(to, r->result, r->results, o->of[K_RESULTS])) && close_record(to, from);
}

static bool write_event(const audit *a, const object *o, out *to)
{
    uint32_t number, instance;
    const request *r;
    unsigned char *from;
    if (has(o, K_ASK)) {
        from = open_record(to, ASK);
        if (from == NULL || (r = named(a, o, K_ASK, &number)) == NULL)
            return false;
        put(to, number, 2);
        return write_values(to, r->param, r->params, o->of[K_ARGS]) && close_record(to, from);
    }
    if (has(o, K_REPORT))
        return (r = named(a, o, K_REPORT, &number)) != NULL && write_report(r, o, number, to);
    if (has(o, K_OBSERVE)) {
        text plain;
        exover_value value;
        from = open_record(to, OBSERVE);
        if (from == NULL || !read_plain(o, K_OBSERVE, &plain) || !has(o, K_VALUE))
            return false;
        const int32_t found = find(a, plain.at, (size_t)(plain.end - plain.at), true);
        if (found == NOBODY || !read_value(&a->observables[found], o->of[K_VALUE], &value))
            return false;
        put(to, (uint32_t)found, 2);
        memcpy(to->at, &value.bits, 8);
        to->at += 8;
        return close_record(to, from);
    }
    if ((r = named(a, o, K_ABORT, &number)) == NULL)
        return false;
    const bool waiting = has(o, K_WAITING) && *o->of[K_WAITING].at == 't';
    from = open_record(to, waiting ? ABORT_WAITING : ABORT);
    if (from == NULL || (!waiting && !read_instance(o, r, &instance)))
        return false;
    put(to, number, 2);
    if (!waiting)
        put(to, instance, 2);
    return close_record(to, from);
}

/* Write a deed; what is none is passed over. */
static bool write_deed(const audit *a, const object *o, out *to)
{
    static const struct {
        enum key key;
        int kind;
    } DEED[] = {{K_LAUNCH, LAUNCHED}, {K_KILL, KILLED}, {K_WAIT, WAITED}, {K_REJECT, REJECTED}};
    for (int i = 0; i < 4; i++) {
        if (!has(o, DEED[i].key))
            continue;
        uint32_t number, instance = 0;
        const request *r = named(a, o, DEED[i].key, &number);
        unsigned char *from = open_record(to, DEED[i].kind);
        if (r == NULL || from == NULL || (i < 2 && !read_instance(o, r, &instance)))
            return false;
        put(to, number, 2);
        if (i < 2)
            put(to, instance, 2);
        if (i == 0) {
            put(to, has(o, K_ARGS), 1);
            if (has(o, K_ARGS) && !write_values(to, r->param, r->params, o->of[K_ARGS]))
                return false;
        }
        return close_record(to, from);
    }
    return true;
}

static bool write_actions(const audit *a, text t, out *to)
{
    text value;
    bool first = true;
    if (!takes(&t, '['))
        return false;
    for (int more = 1; more == 1; more = behind_part(&t, ']')) {
        object action;
        const int found = next_part(&t, &first, ']', NULL, &value);
        if (found <= 0)
            break;
        if (!read_object(&value, &action) || !write_deed(a, &action, to))
            return false;
    }
    unsigned char *from = open_record(to, TOLD);
    return from != NULL && close_record(to, from);
}

static bool is_event(const object *o)
{
    return has(o, K_ASK) || has(o, K_REPORT) || has(o, K_OBSERVE) || has(o, K_ABORT);
}

static bool ends(const object *o)
{
    return !has(o, K_ASK) && (has(o, K_REPORT) || (!has(o, K_OBSERVE) && has(o, K_ABORT)));
}

/* Whether one of the actions says that the event was none: 1 or 0; if they are odd, -1. */
static int say_invalid(text t)
{
    text value;
    bool first = true;
    int said = 0;
    if (!takes(&t, '['))
        return -1;
    for (int more = 1; more == 1; more = behind_part(&t, ']')) {
        object action;
        const int found = next_part(&t, &first, ']', NULL, &value);
        if (found == 0)
            break;
        if (found < 0 || !read_object(&value, &action))
            return -1;
        said = said || has(&action, K_INVALID);
    }
    return said;
}

/* Write the event of a line, or that it was none: a report or an abort that is answered so. */
static bool write_answered(const audit *a, const object *line, const object *event, out *to)
{
    const int said = has(line, K_ACTIONS) && ends(event) ? say_invalid(line->of[K_ACTIONS]) : 0;
    if (said <= 0)
        return said == 0 && write_event(a, event, to);
    unsigned char *from = open_record(to, VOID);
    return from != NULL && close_record(to, from);
}

static bool is_deed(const object *o)
{
    return has(o, K_LAUNCH) || has(o, K_KILL) || has(o, K_WAIT) || has(o, K_REJECT);
}

static bool write_line(const audit *a, const object *o, out *to)
{
    if (has(o, K_EVENT)) {
        object event;
        text t = o->of[K_EVENT];
        if (!read_object(&t, &event) || !is_event(&event) || !write_answered(a, o, &event, to))
            return false;
    } else if (is_event(o)) {
        if (!write_answered(a, o, o, to))
            return false;
    } else if (is_deed(o)) {
        return write_deed(a, o, to);
    } else if (has(o, K_LOST)) {
        return false;
    } else if (!has(o, K_ACTIONS)) {
        return has(o, K_REFUSED) || has(o, K_ALARM);
    }
    return !has(o, K_ACTIONS) || write_actions(a, o->of[K_ACTIONS], to);
}

/* Write the records of a line without its end; returns how many bytes they have, -1 if it is odd. */
long audit_line(const audit *a, const char *line, size_t size, unsigned char *records, size_t room)
{
    text t = {line, line + size};
    out to = {records, records + room};
    object o;
    skip_blanks(&t);
    if (t.at == t.end)
        return 0;
    if (!read_object(&t, &o))
        return -1;
    skip_blanks(&t);
    double time = NAN;
    unsigned char *from = open_record(&to, TIME);
    if (t.at != t.end || (has(&o, K_TIME) && !read_real(o.of[K_TIME], &time)))
        return -1;
    if (from == NULL)
        return -1;
    memcpy(to.at, &time, 8);
    to.at += 8;
    return close_record(&to, from) && write_line(a, &o, &to) ? (long)(to.at - records) : -1;
}

/* ---- actions in the line behind ---- */

enum { FIRST = 4 + 9, CUT = -2 }; /* FIRST: the bytes of the record of the time, which every line begins with */

/* Whether the records of a line are a report or an abort and nothing else, so that its actions may stand in the next line. */
static bool is_bare_end(const unsigned char *records, long bytes)
{
    if (bytes < FIRST + 5)
        return false;
    const int kind = records[FIRST + 4];
    return FIRST + 4 + (long)length_at(records + FIRST) == bytes && (kind == REPORT || kind == ABORT || kind == ABORT_WAITING);
}

/* Make of the event of a line one that was none; returns how many bytes its records have. */
static long make_void(unsigned char *records)
{
    out to = {records + FIRST, records + FIRST + 24};
    unsigned char *from = open_record(&to, VOID);
    (void)close_record(&to, from);
    return (long)(to.at - records);
}

/* Whether a line is one of actions that say that the event before was none: 1 or 0; if it is odd, -1. */
static int denies(text line)
{
    object o;
    if (!read_object(&line, &o))
        return -1;
    skip_blanks(&line);
    if (line.at != line.end)
        return -1;
    if (has(&o, K_EVENT) || is_event(&o) || is_deed(&o) || has(&o, K_LOST) || !has(&o, K_ACTIONS))
        return 0;
    return say_invalid(o.of[K_ACTIONS]);
}

/* What the first line that is not blank says of the event before, as `denies`; 0 if none ends within MOST_LINE bytes, CUT if more must
 * be read for that. */
static int answer_behind(const char *data, size_t size, bool last)
{
    const bool all = size <= MOST_LINE;
    text rest = {data, data + (all ? size : MOST_LINE)};
    last = last && all;
    while (rest.at < rest.end) {
        const char *newline = memchr(rest.at, '\n', (size_t)(rest.end - rest.at));
        if (newline == NULL && !last)
            break;
        text line = {rest.at, newline == NULL ? rest.end : newline};
        rest.at = newline == NULL ? rest.end : newline + 1;
        skip_blanks(&line);
        if (line.at != line.end)
            return denies(line);
    }
    return last || size >= MOST_LINE ? 0 : CUT;
}

#endif
