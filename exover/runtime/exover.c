/* exover.c - see exover.h. What a step means is docs/language.md section 4; what the tables say is docs/runtime.md. */
#include "exover.h"

#define NONE (-1)   /* no entry, no slot, no argument; as a node, the end of a path */
#define ALWAYS (-2) /* as a predicate: true of all arguments */
#define MOST_SLOTS 0x1000000

/* Sections of the tables, then what else a field can count. */
enum {
    NODES, ENTRIES, REQUESTS, PARAMS, ORDERS, FEATURES, PASTS, AMOUNTS, EFFECTS, VARIABLES, LATCHES, STOCKS, RULES,
    LAUNCHES, LIMITS, CONFLICTS, REASONS, SUMS, LISTS, REALS, FLAG, TYPE, ROLE, DENIALS, BLOCKS, NATURAL, ANY
};
enum { REJECT = 1, WAIT, CLEAR, SETTLE, KILL, DISMISS, LAUNCH, VIOLATION, AGREE }; /* actions of nodes */
enum { REAL = 3 };                                                                  /* of types */
enum { POSTER = 0 };                                                                /* of roles */
enum { SET = 0 };                                                                   /* of effects */
/* What a slot (the first three) or a waiting place holds; less one, the entry of a feature. */
enum { EMPTY, RUNNING, STOPPING, WAITING, CLEARING };
/* What the end of a step has to look at: rules, broken rules, marks of this step, launch rules, a fault. */
enum { DIRTY = 1, BROKEN = 2, MARKED = 4, REQUIRED = 8, FAULTY = 16 };

/* The layout of the tables relies on this: records are arrays of words, doubles have 64 bits. */
typedef char records_are_packed[sizeof(exover_request) == 26 * sizeof(exover_word)
                                && sizeof(exover_variable) == 16 * sizeof(exover_word)
                                && sizeof(exover_feature) == 7 * sizeof(exover_word) ? 1 : -1];
typedef char doubles_have_64_bits[sizeof(double) == 8 && sizeof(exover_value) == 8 ? 1 : -1];
typedef char states_hold_words[EXOVER_STATE >= EXOVER_WIDTH ? 1 : -1];

/* Whether there can be records of a section; if not, the compiler drops what follows. */
#define USES(section) ((EXOVER_USES) >> (section) & 1)

#ifdef __GNUC__
#define SELDOM __attribute__((noinline))
#else
#define SELDOM
#endif

/* Record `index` of a section; `c` is the checker. */
#define RECORD(type, section, index) ((const exover_##type *)c->sections[section] + (index))
#define REQUEST(index) RECORD(request, REQUESTS, index)
#define LIST ((const exover_word *)c->sections[LISTS])

/* ---- bits ---- */

static void set_bit(uint32_t *bits, exover_int index)
{
    bits[index >> 5] |= (uint32_t)1 << (index & 31);
}

static void clear_bit(uint32_t *bits, exover_int index)
{
    bits[index >> 5] &= ~((uint32_t)1 << (index & 31));
}

static bool has_bit(const uint32_t *bits, exover_int index)
{
    return (bits[index >> 5] >> (index & 31)) & 1;
}

/* The least set bit from `index` on, `end` if there is none. */
static exover_int next_bit(const uint32_t *bits, exover_int index, exover_int end)
{
    while (index < end) {
        uint32_t left = bits[index >> 5] >> (index & 31);
        if (left & 1)
            break;
        index = left == 0 ? (index | 31) + 1 : index + 1;
    }
    return index < end ? index : end;
}

/* ---- answers ---- */

static SELDOM void fault(exover *c, exover_status cause)
{
    if (c->fault == EXOVER_READY)
        c->fault = cause;
    c->attention |= FAULTY;
}

static void answer(exover *c, enum exover_kind kind, exover_int request, exover_int slot, exover_int reason)
{
    if (c->count == c->capacity) {
        fault(c, EXOVER_FAULT_ACTIONS);
        return;
    }
    exover_action *action = &c->actions[c->count++];
    action->kind = (exover_word)kind;
    action->request = (exover_word)request;
    action->slot = (exover_word)slot;
    action->reason = (exover_word)reason;
}

static SELDOM size_t invalid(exover *c, int code)
{
    answer(c, EXOVER_INVALID, NONE, NONE, code);
    return 1;
}

static SELDOM size_t deny(exover *c, exover_int request)
{
    answer(c, EXOVER_REJECT, request, NONE, EXOVER_FAULTY);
    return 1;
}

/* ---- the state vector and the diagrams ---- */

static void bump(exover *c, const exover_entry *entry, exover_int *at, exover_uint delta)
{
    *at = (exover_int)((exover_uint)*at + delta);
    for (exover_word i = entry->rules; USES(RULES) && i < entry->rules_end; i++) {
        set_bit(c->dirty, LIST[i]);
        c->attention |= DIRTY;
    }
}

/* Add to an entry and to the sums it is part of; a sum is part of no sum. */
static void add(exover *c, exover_int index, exover_int delta)
{
    const exover_entry *entry = RECORD(entry, ENTRIES, index);
    bump(c, entry, &c->vector[index], (exover_uint)delta);
    for (exover_word i = entry->sums; USES(SUMS) && i < entry->sums_end; i++) {
        const exover_sum *sum = RECORD(sum, SUMS, i);
        bump(c, RECORD(entry, ENTRIES, sum->entry), &c->vector[sum->entry],
             (exover_uint)sum->factor * (exover_uint)delta);
    }
}

static void put(exover *c, exover_int index, exover_int value)
{
    if (index >= 0 && c->vector[index] != value)
        add(c, index, (exover_int)((exover_uint)value - (exover_uint)c->vector[index]));
}

/* The first action on the path from a node, NONE if there is none. */
static exover_int walk(const exover *c, exover_int index)
{
    while (index >= 0) {
        const exover_node *node = RECORD(node, NODES, index);
        if (node->code < 0)
            break;
        index = c->vector[node->code] <= node->bound ? node->low : node->high;
    }
    return index;
}

/* Whether a predicate or condition holds: its path says `AGREE`. */
static bool agrees(const exover *c, exover_int predicate)
{
    return walk(c, predicate) != NONE;
}

/* Collect the actions on the path from a node, none of which is done before the path has ended. */
static exover_int collect(exover *c, exover_int index)
{
    exover_int found = 0;
    while ((index = walk(c, index)) >= 0) {
        if (found == RECORD(limits, LIMITS, 0)->actions) {
            fault(c, EXOVER_FAULT_PATH);
            return 0;
        }
        c->path[found++] = (exover_word)index;
        index = RECORD(node, NODES, index)->low;
    }
    return found;
}

static const exover_node *step(const exover *c, exover_int index)
{
    return RECORD(node, NODES, c->path[index]);
}

/* ---- values ---- */

/* Put a value into the entry that tests of it read: of a real, twice the number of cuts below it, one more if it is a
 * cut itself. */
static void measure(exover *c, exover_word type, const exover_gauge *gauge, exover_value value)
{
    if (!USES(REALS) || type != REAL) {
        put(c, gauge->value, (exover_int)value.integer);
    } else if (gauge->rank >= 0) {
        exover_int low = gauge->cuts, high = gauge->cuts_end;
        while (low < high) {
            exover_int middle = (low + high) / 2;
            if (c->reals[middle].real < value.real)
                low = middle + 1;
            else
                high = middle;
        }
        bool cut = low < gauge->cuts_end && c->reals[low].real <= value.real;
        put(c, gauge->rank, 2 * (low - gauge->cuts) + cut);
    }
}

/* What stands at a side of a comparison: parameter `k`, result `k - params`, or poster `-1 - k`. */
static double side(const exover *c, exover_int k, exover_int params)
{
    if (k < 0)
        return c->raw[RECORD(variable, VARIABLES, -1 - k)->raw];
    return k < params ? c->loaded_args[k].real : c->loaded_results[k - params].real;
}

static void compare(exover *c, exover_int from, exover_int to, exover_int params, exover_int all)
{
    for (; USES(ORDERS) && from < to; from++) {
        const exover_order *order = RECORD(order, ORDERS, from);
        if (order->left < all && order->right < all) {
            double left = side(c, order->left, params), right = side(c, order->right, params);
            put(c, order->entry, left < right ? 0 : left > right ? 2 : 1);
        }
    }
}

/* Put arguments, and results if there are any, into the entries that tests of them read. */
static void load(exover *c, const exover_request *row, const exover_value *args, const exover_value *results)
{
    exover_int params = row->results - row->params, all = results ? row->params_end - row->params : params;
    if (!USES(PARAMS) || all == 0 || (c->loaded_args == args && c->loaded_results == results))
        return;
    c->loaded_args = args;
    c->loaded_results = results;
    for (exover_int k = 0; k < all; k++) {
        const exover_param *param = RECORD(param, PARAMS, row->params + k);
        measure(c, param->domain.type, &param->gauge, k < params ? args[k] : results[k - params]);
    }
    compare(c, row->orders, row->orders_end, params, all);
}

static bool fits(exover *c, const exover_request *row, exover_int predicate, const exover_value *args,
                 const exover_value *results)
{
    if (predicate >= 0)
        load(c, row, args, results);
    return agrees(c, predicate);
}

/* ---- slots and waiting places: slot `instances` of a request is its waiting place ---- */

static exover_value *kept(const exover *c, exover_int request, exover_int slot)
{
    const exover_request *row = REQUEST(request);
    return c->values + c->args[request] + slot * (row->results - row->params);
}

static uint8_t *phase_of(const exover *c, exover_int request, exover_int slot)
{
    return &c->phases[REQUEST(request)->slots + request + slot];
}

static uint8_t *place_of(const exover *c, exover_int request)
{
    return phase_of(c, request, REQUEST(request)->instances);
}

/* What a slot or place counts for in a feature that looks at arguments. */
static SELDOM exover_int weigh(exover *c, exover_int request, exover_int slot, const exover_feature *feature)
{
    const exover_value *args = kept(c, request, slot);
    if (!fits(c, REQUEST(request), feature->predicate, args, NULL))
        return 0;
    return feature->weight < 0 ? 1 : (exover_int)args[feature->weight].integer;
}

/* Count what a slot or place holds in, or with sign -1 out of, every feature of its request. */
static void tally(exover *c, exover_int request, exover_int slot, uint8_t phase, exover_int sign)
{
    if (phase == EMPTY)
        return;
    for (exover_word i = REQUEST(request)->features; i < REQUEST(request)->features_end; i++) {
        const exover_feature *feature = RECORD(feature, FEATURES, i);
        exover_int entry = feature->entries[phase - 1], weight = 1;
        if (entry < 0 || (feature->slot != NONE && feature->slot != slot))
            continue;
        if (feature->predicate != ALWAYS || feature->weight >= 0)
            weight = weigh(c, request, slot, feature);
        if (weight != 0)
            add(c, entry, sign * weight);
    }
}

/* Let a slot or place hold something else: in this phase, these arguments. */
static void hold(exover *c, exover_int request, exover_int slot, uint8_t next, const exover_value *args)
{
    const exover_request *row = REQUEST(request);
    uint8_t *phase = phase_of(c, request, slot);
    exover_value *own = kept(c, request, slot);
    if (slot == row->instances) {
        if (*phase == next && (next == EMPTY || own == args))
            return;
        c->waiting += (next != EMPTY) - (*phase != EMPTY);
        if (next != EMPTY)
            set_bit(c->taken, request);
        else
            clear_bit(c->taken, request);
    }
    tally(c, request, slot, *phase, -1);
    *phase = next;
    c->changed = true;
    if (next != EMPTY && own != args) {
        for (exover_int k = 0; USES(PARAMS) && k < row->results - row->params; k++)
            own[k] = args[k];
        c->loaded_args = NULL;
    }
    tally(c, request, slot, next, 1);
}

static void vacate(exover *c, exover_int request, exover_int reason)
{
    hold(c, request, REQUEST(request)->instances, EMPTY, NULL);
    answer(c, EXOVER_REJECT, request, NONE, reason);
}

static void kill(exover *c, exover_int request, exover_int slot, exover_int reason)
{
    if (*phase_of(c, request, slot) == RUNNING) {
        hold(c, request, slot, STOPPING, kept(c, request, slot));
        answer(c, EXOVER_KILL, request, slot, reason);
    }
}

/* Kill what a node says: all slots of a request, or one slot of all. */
static void kill_target(exover *c, const exover_node *node)
{
    exover_int target = node->high, request = 0, end = c->counts[REQUESTS];
    if (target >= 0) {
        for (exover_int slot = 0; slot < REQUEST(target)->instances; slot++)
            kill(c, target, slot, node->bound);
        return;
    }
    target = -1 - target;
    while (end - request > 1) {
        exover_int middle = (request + end) / 2;
        if (REQUEST(middle)->slots <= target)
            request = middle;
        else
            end = middle;
    }
    kill(c, request, target - REQUEST(request)->slots, node->bound);
}

/* ---- variables, pasts, effects ---- */

/* Count the slots out or in whose features read a poster. */
static void recount(exover *c, const exover_variable *row, exover_int sign)
{
    for (exover_word i = row->refresh; USES(ORDERS) && i < row->refresh_end; i++)
        for (exover_int slot = 0; slot < REQUEST(LIST[i])->instances; slot++)
            tally(c, LIST[i], slot, *phase_of(c, LIST[i], slot), sign);
}

/* Let a poster, state or latch read a value. */
static void read(exover *c, exover_int variable, exover_value value)
{
    const exover_variable *row = RECORD(variable, VARIABLES, variable);
    recount(c, row, -1);
    measure(c, row->domain.type, &row->gauge, value);
    if (USES(ORDERS) && row->raw >= 0) {
        c->raw[row->raw] = value.real;
        c->loaded_args = NULL;
    }
    compare(c, row->orders, row->orders_end, 0, 0);
    recount(c, row, 1);
}

static void read_integer(exover *c, exover_int variable, exover_int number)
{
    exover_value value;
    value.integer = number;
    read(c, variable, value);
}

static void latch(exover *c, exover_int cleared_by)
{
    for (exover_int i = 0; USES(LATCHES) && i < c->counts[LATCHES]; i++) {
        const exover_latch *row = RECORD(latch, LATCHES, i);
        bool set = agrees(c, row->condition), changes = set;
        for (exover_word k = row->resets; k < row->resets_end; k++)
            changes |= LIST[k] == cleared_by;
        if (changes)
            read_integer(c, row->variable, set);
    }
}

static void affect(exover *c, const exover_word *edge)
{
    for (exover_word i = edge[0]; USES(EFFECTS) && i < edge[1]; i++) {
        const exover_effect *effect = RECORD(effect, EFFECTS, i);
        if (effect->kind == SET) {
            read_integer(c, effect->target, effect->value);
        } else {
            const exover_request *row = REQUEST(effect->target);
            for (exover_word k = row->pasts; k < row->pasts_end; k++)
                put(c, RECORD(past, PASTS, k)->entry, 0);
        }
    }
}

/* Take (sign -1) what a launch consumes, or give (sign 1) what a success produces, never above the capacity. */
static void supply(exover *c, const exover_request *row, exover_int from, exover_int to, const exover_value *args,
                   exover_int sign)
{
    for (; USES(AMOUNTS) && from < to; from++) {
        const exover_amount *amount = RECORD(amount, AMOUNTS, from);
        const exover_stock *stock = RECORD(stock, STOCKS, amount->stock);
        if (stock->entry >= 0 && fits(c, row, amount->predicate, args, NULL)) {
            exover_int room = (exover_int)((exover_uint)stock->capacity - (exover_uint)c->vector[stock->entry]);
            add(c, stock->entry, sign < 0 ? -amount->amount : amount->amount < room ? amount->amount : room);
        }
    }
}

/* ---- decisions ---- */

static void launch(exover *c, exover_int request, const exover_value *args, exover_int required)
{
    const exover_request *row = REQUEST(request);
    exover_int slot = 0;
    while (*phase_of(c, request, slot) != EMPTY && slot < row->instances)
        slot++;
    if (slot == row->instances) {
        fault(c, EXOVER_FAULT_DECISION);
        return;
    }
    if (c->waiting)
        hold(c, request, row->instances, EMPTY, NULL);
    hold(c, request, slot, RUNNING, args);
    supply(c, row, row->consumes, row->produces, args, -1);
    affect(c, &row->effects[0]);
    answer(c, EXOVER_LAUNCH, request, slot, required);
}

/* The first action of the decision on a request; NULL if there is none, which is a fault. */
static const exover_node *decide(exover *c, exover_int request, const exover_value *args)
{
    const exover_request *row = REQUEST(request);
    if (row->params != row->results)
        load(c, row, args, NULL);
    exover_int index = walk(c, row->decide);
    if (index < 0) {
        fault(c, EXOVER_FAULT_DECISION);
        return NULL;
    }
    return RECORD(node, NODES, index);
}

/* Do what a decision says that is no rejection; return what the newcomer waits for, EXOVER_UNSAID if it does not. */
static exover_int carry_out(exover *c, exover_int request, const exover_value *args, const exover_node *first,
                            exover_int required)
{
    exover_int waits = EXOVER_UNSAID, found = collect(c, (exover_int)(first - RECORD(node, NODES, 0)));
    for (exover_int i = 0; i < found; i++) {
        const exover_node *node = step(c, i);
        switch (-node->code) {
        case WAIT:
        case CLEAR:
        case SETTLE:
            waits = node->bound;
            hold(c, request, REQUEST(request)->instances, node->code == -WAIT ? WAITING : CLEARING, args);
            break;
        case KILL:
            kill_target(c, node);
            break;
        case DISMISS:
            if (*place_of(c, node->high) != EMPTY)
                vacate(c, node->high, node->bound);
            break;
        case LAUNCH:
            launch(c, request, args, required);
            break;
        default:
            fault(c, EXOVER_FAULT_DECISION);
        }
    }
    return waits;
}

static void ask(exover *c, exover_int request, const exover_value *args, exover_int required)
{
    bool taken = c->waiting && *place_of(c, request) != EMPTY;
    exover_int reason = EXOVER_BUSY;
    if (!taken || REQUEST(request)->interrupts_self) {
        const exover_node *first = decide(c, request, args);
        if (first == NULL)
            return;
        if (first->code != -REJECT) {
            if (taken)
                answer(c, EXOVER_REJECT, request, NONE, EXOVER_SUPERSEDED);
            reason = carry_out(c, request, args, first, required);
            if (reason != EXOVER_UNSAID)
                answer(c, EXOVER_WAIT, request, NONE, reason);
            return;
        }
        reason = first->bound;
    }
    answer(c, EXOVER_REJECT, request, NONE, reason);
}

/* ---- steps 3 to 5 ---- */

static void recover(exover *c)
{
    exover_int rule = NONE, end = c->counts[RULES];
    c->attention &= ~(uint32_t)DIRTY;
    while ((rule = next_bit(c->dirty, rule + 1, end)) < end) {
        clear_bit(c->dirty, rule);
        clear_bit(c->broken, rule);
        exover_int found = collect(c, RECORD(rule, RULES, rule)->root);
        for (exover_int i = 0; i < found; i++) {
            const exover_node *node = step(c, i);
            if (node->code == -KILL) {
                kill_target(c, node);
            } else if (node->code == -VIOLATION) {
                set_bit(c->broken, rule);
                c->attention |= BROKEN;
            }
        }
    }
}

static void launch_required(exover *c)
{
    for (exover_int i = 0; USES(LAUNCHES) && i < c->counts[LAUNCHES]; i++) {
        const exover_launch_rule *row = RECORD(launch_rule, LAUNCHES, i);
        if (has_bit(c->marks, i) || !agrees(c, row->condition))
            continue;
        set_bit(c->marks, i);
        c->attention |= MARKED;
        const exover_request *request = REQUEST(row->request);
        for (exover_int k = 0; k < request->results - request->params; k++) {
            exover_word word = LIST[row->args + k];
            if (RECORD(param, PARAMS, request->params + k)->domain.type == REAL)
                c->scratch[k] = c->reals[word];
            else
                c->scratch[k].integer = word;
        }
        c->loaded_args = NULL;
        ask(c, row->request, c->scratch, row->reason);
    }
}

static void settle(exover *c)
{
    exover_int request = NONE, end = c->counts[REQUESTS];
    while ((request = next_bit(c->taken, request + 1, end)) < end) {
        exover_int place = REQUEST(request)->instances, mark = c->counts[LAUNCHES] + request;
        const exover_value *args = kept(c, request, place);
        const exover_node *first = decide(c, request, args);
        if (first == NULL)
            return;
        if (first->code == -REJECT) {
            vacate(c, request, first->bound);
        } else if (first->code != -LAUNCH && first->code != -DISMISS
                   && (first->code == -WAIT || has_bit(c->marks, mark))) {
            if (*place_of(c, request) == CLEARING) {
                set_bit(c->marks, mark);
                c->attention |= MARKED;
            }
            hold(c, request, place, WAITING, args);
        } else {
            carry_out(c, request, args, first, EXOVER_UNSAID);
        }
    }
}

/* Raise every rule that is still broken once; the copies of a rule stand together. */
static void violations(exover *c)
{
    exover_int rule = NONE, end = c->counts[RULES], last = NONE;
    c->attention &= ~(uint32_t)BROKEN;
    while ((rule = next_bit(c->broken, rule + 1, end)) < end) {
        exover_int reason = RECORD(rule, RULES, rule)->reason;
        if (reason != last)
            answer(c, EXOVER_VIOLATION, NONE, NONE, reason);
        last = reason;
        c->attention |= BROKEN;
    }
}

/* Begin an event; false if everything is denied. */
static bool begin(exover *c)
{
    if (c->actions == NULL) {
        c->actions = &c->denial;
        c->capacity = 1;
        fault(c, EXOVER_NOT_LOADED);
    }
    c->count = 0;
    c->loaded_args = NULL;
    return c->fault == EXOVER_READY;
}

/* Nothing starts in a step that ends with a fault, but what was told to stop shall stop. */
static void keep_kills(exover *c, exover_int request)
{
    exover_int kept = 0;
    for (exover_int i = 0; i < c->count; i++)
        if (c->actions[i].kind == EXOVER_KILL)
            c->actions[kept++] = c->actions[i];
    c->count = kept;
    c->capacity++; /* the last place was kept for this */
    deny(c, request);
}

/* Repeat steps 3 to 5 until nothing changes. */
static void repeat(exover *c)
{
    exover_int passes = RECORD(limits, LIMITS, 0)->passes;
    c->changed = true;
    while (c->changed && (c->waiting || (c->attention & (DIRTY | REQUIRED))) && c->fault == EXOVER_READY) {
        c->changed = false;
        if (passes-- == 0)
            fault(c, EXOVER_FAULT_PASSES);
        if (USES(RULES) && (c->attention & DIRTY))
            recover(c);
        launch_required(c);
        if (c->waiting)
            settle(c);
    }
}

/* The end of a step that leaves something to look at. */
static SELDOM size_t attend(exover *c, exover_int request)
{
    repeat(c);
    if (USES(RULES) && (c->attention & BROKEN))
        violations(c);
    if (c->attention & MARKED) {
        c->attention &= ~(uint32_t)MARKED;
        for (exover_int i = 0; i < c->counts[LAUNCHES] + c->counts[REQUESTS]; i++)
            clear_bit(c->marks, i);
    }
    if (c->attention & FAULTY)
        keep_kills(c, request);
    return (size_t)c->count;
}

/* End a step; return the number of answers. */
static size_t finish(exover *c, exover_int request)
{
    return c->attention | (uint32_t)c->waiting ? attend(c, request) : (size_t)c->count;
}

/* ---- validation: 0, or an exover_invalid ---- */

static bool in_domain(const exover *c, const exover_domain *domain, exover_value value)
{
    if (USES(REALS) && domain->type == REAL)
        return (value.bits >> 52 & 0x7ff) != 0x7ff && value.real >= c->reals[domain->low].real
               && value.real <= c->reals[domain->high].real;
    return value.integer >= domain->low && value.integer <= domain->high;
}

static int wrong_values(const exover *c, exover_int from, exover_int to, const exover_value *values, size_t count)
{
    size_t expected = (size_t)(to - from);
    if (count != expected || (count != 0 && values == NULL))
        return count > expected ? EXOVER_UNKNOWN_ARGUMENT : EXOVER_MISSING_ARGUMENT;
    for (; USES(PARAMS) && from < to; from++, values++)
        if (!in_domain(c, &RECORD(param, PARAMS, from)->domain, *values))
            return EXOVER_OUT_OF_RANGE;
    return 0;
}

/* A checker that was not loaded has no requests. */
static int wrong_slot(const exover *c, int32_t request, int32_t slot)
{
    if (request < 0 || request >= c->counts[REQUESTS])
        return EXOVER_UNKNOWN_REQUEST;
    return slot < 0 || slot >= REQUEST(request)->instances ? EXOVER_OUT_OF_RANGE : 0;
}

/* ---- events ---- */

size_t exover_ask(exover *c, int32_t request, const exover_value *args, size_t count)
{
    if (!begin(c))
        return deny(c, request);
    int wrong = wrong_slot(c, request, 0);
    if (wrong == 0)
        wrong = wrong_values(c, REQUEST(request)->params, REQUEST(request)->results, args, count);
    if (wrong != 0)
        return invalid(c, wrong);
    ask(c, request, args, EXOVER_UNSAID);
    return finish(c, request);
}

size_t exover_report(exover *c, int32_t request, int32_t slot, enum exover_outcome outcome, int32_t status,
                     const exover_value *results, size_t count)
{
    bool ready = begin(c);
    int wrong = wrong_slot(c, request, slot);
    if (wrong != 0)
        return invalid(c, wrong);
    const exover_request *row = REQUEST(request);
    if (outcome != EXOVER_OK && outcome != EXOVER_FAILED && outcome != EXOVER_INTERRUPTED)
        wrong = EXOVER_BAD_EVENT;
    else if (status < NONE || (status >= 0 && (outcome != EXOVER_FAILED || status >= row->statuses)))
        wrong = EXOVER_UNKNOWN_STATUS;
    else if (outcome == EXOVER_OK)
        wrong = wrong_values(c, row->results, row->params_end, results, count);
    if (wrong == 0 && *phase_of(c, request, slot) == EMPTY)
        wrong = EXOVER_NOT_ACTIVE;
    if (wrong != 0)
        return invalid(c, wrong);
    if (!ready) {
        *phase_of(c, request, slot) = EMPTY; /* the rest of the state is not trusted any more */
        return deny(c, request);
    }
    const exover_value *args = kept(c, request, slot);
    hold(c, request, slot, EMPTY, args);
    put(c, row->last, (exover_int)outcome);
    if (outcome == EXOVER_OK) {
        for (exover_word i = row->pasts; USES(PASTS) && i < row->pasts_end; i++) {
            const exover_past *past = RECORD(past, PASTS, i);
            put(c, past->entry, fits(c, row, past->predicate, args, results));
        }
        supply(c, row, row->produces, row->produces_end, args, 1);
    }
    affect(c, &row->effects[outcome]);
    latch(c, outcome == EXOVER_OK ? request : NONE);
    return finish(c, request);
}

size_t exover_observe(exover *c, int32_t poster, exover_value value)
{
    if (!begin(c))
        return deny(c, NONE);
    const exover_variable *row = RECORD(variable, VARIABLES, poster);
    if (!USES(VARIABLES) || poster < 0 || poster >= c->counts[VARIABLES] || row->role != POSTER)
        return invalid(c, EXOVER_UNKNOWN_POSTER);
    if (!in_domain(c, &row->domain, value)) {
        invalid(c, EXOVER_OUT_OF_RANGE);
        if (!row->has_fallback)
            return 1;
        value.integer = row->fallback;
        if (row->domain.type == REAL)
            value = c->reals[row->fallback];
    }
    read(c, poster, value);
    latch(c, NONE);
    return finish(c, NONE);
}

size_t exover_level(exover *c, int32_t stock, int64_t level)
{
    if (!begin(c))
        return deny(c, NONE);
    if (!USES(STOCKS) || stock < 0 || stock >= c->counts[STOCKS])
        return invalid(c, EXOVER_UNKNOWN_POSTER);
    const exover_stock *row = RECORD(stock, STOCKS, stock);
    if (level < 0 || level > row->capacity)
        return invalid(c, EXOVER_OUT_OF_RANGE);
    put(c, row->entry, (exover_int)level);
    latch(c, NONE);
    return finish(c, NONE);
}

size_t exover_abort(exover *c, int32_t request, int32_t slot)
{
    bool ready = begin(c);
    int wrong = wrong_slot(c, request, slot);
    if (wrong == 0 && *phase_of(c, request, slot) == EMPTY)
        wrong = EXOVER_NOTHING_TO_ABORT;
    if (wrong != 0)
        return invalid(c, wrong);
    if (!ready) {
        *phase_of(c, request, slot) = STOPPING;
        answer(c, EXOVER_KILL, request, slot, EXOVER_ABORTED);
        return 1;
    }
    kill(c, request, slot, EXOVER_ABORTED);
    return finish(c, request);
}

size_t exover_abort_waiting(exover *c, int32_t request)
{
    if (!begin(c))
        return deny(c, request);
    int wrong = wrong_slot(c, request, 0);
    if (wrong == 0 && *place_of(c, request) == EMPTY)
        wrong = EXOVER_NOTHING_TO_ABORT;
    if (wrong != 0)
        return invalid(c, wrong);
    vacate(c, request, EXOVER_ABORTED);
    return finish(c, request);
}

const exover_value *exover_args(const exover *c, int32_t request, int32_t slot)
{
    return wrong_slot(c, request, slot) ? NULL : kept(c, request, slot);
}

size_t exover_arity(const exover *c, int32_t request)
{
    return wrong_slot(c, request, 0) ? 0 : (size_t)(REQUEST(request)->results - REQUEST(request)->params);
}

bool exover_unchecked(const exover *c)
{
    return c->flags & 1;
}

exover_status exover_fault(const exover *c)
{
    return c->actions == NULL ? EXOVER_NOT_LOADED : c->fault;
}

/* ---- loading ---- */

static const uint8_t FIELDS[EXOVER_SECTIONS] = {4, 5, 26, 7, 3, 7, 2, 3, 3, 16, 4, 3, 2, 4, 4, 2, 1, 2, 1};

/* What a field may be, in one byte: of what it is the index, and how. */
#define AT(what) (what)
#define OR_NONE(what) (32 | (what))
#define OR_ALWAYS(what) (64 | (what))
#define FROM(what) (96 | (what))       /* an index or the end */
#define TO(what) (128 | (what))        /* likewise, and not less than the field before */
#define IF_REAL(fields) (160 | (fields)) /* of a real, an index of doubles; its type stands so many fields before */

static const uint8_t SCHEMA[] = {
    ANY, ANY, OR_NONE(NODES), ANY,                                           /* nodes */
    ANY, FROM(LISTS), TO(LISTS), FROM(SUMS), TO(SUMS),                       /* entries */
    AT(NODES), NATURAL, NATURAL, NATURAL, AT(FLAG), NATURAL,                 /* requests */
    FROM(PARAMS), TO(PARAMS), TO(PARAMS), FROM(ORDERS), TO(ORDERS), FROM(FEATURES), TO(FEATURES), FROM(PASTS),
    TO(PASTS), FROM(AMOUNTS), TO(AMOUNTS), TO(AMOUNTS), FROM(EFFECTS), TO(EFFECTS), TO(EFFECTS), TO(EFFECTS),
    TO(EFFECTS), OR_NONE(ENTRIES), FROM(CONFLICTS), TO(CONFLICTS),
    AT(TYPE), IF_REAL(1), IF_REAL(2), FROM(REALS), TO(REALS), OR_NONE(ENTRIES), OR_NONE(ENTRIES), /* params */
    ANY, ANY, OR_NONE(ENTRIES),                                              /* orders */
    OR_ALWAYS(NODES), ANY, ANY, OR_NONE(ENTRIES), OR_NONE(ENTRIES), OR_NONE(ENTRIES), OR_NONE(ENTRIES), /* features */
    OR_ALWAYS(NODES), OR_NONE(ENTRIES),                                      /* pasts */
    AT(STOCKS), NATURAL, OR_ALWAYS(NODES),                                   /* amounts */
    AT(FLAG), NATURAL, ANY,                                                  /* effects */
    AT(ROLE), AT(TYPE), IF_REAL(1), IF_REAL(2), IF_REAL(3), AT(FLAG), IF_REAL(5), FROM(REALS), TO(REALS),
    OR_NONE(ENTRIES), OR_NONE(ENTRIES), OR_NONE(VARIABLES), FROM(LISTS), TO(LISTS), FROM(ORDERS), TO(ORDERS),
    AT(VARIABLES), OR_NONE(NODES), FROM(LISTS), TO(LISTS),                   /* latches */
    NATURAL, NATURAL, OR_NONE(ENTRIES),                                      /* stocks */
    OR_NONE(NODES), NATURAL,                                                 /* rules */
    OR_NONE(NODES), AT(REQUESTS), FROM(LISTS), NATURAL,                      /* launches */
    NATURAL, NATURAL, NATURAL, NATURAL,                                      /* limits */
    AT(BLOCKS), ANY,                                                         /* conflicts */
    AT(DENIALS),                                                             /* reasons */
    AT(ENTRIES), ANY,                                                        /* sums */
    ANY                                                                      /* lists */
};

static bool below(exover_int index, exover_int count)
{
    return index >= 0 && index < count;
}

/* Whether a field is what its byte of the schema says. */
static bool field_holds(const exover *c, const exover_word *word, exover_int reals, unsigned schema)
{
    const exover_int many[] = {2, 4, 3, 3, (c->counts[REQUESTS] + 15) / 16}; /* flags, types, roles, denials, blocks */
    unsigned what = schema & 31u, how = schema & 224u;
    if (how == IF_REAL(0))
        return word[-(int)what] != REAL || below(*word, reals);
    if (what >= NATURAL)
        return what == ANY || *word >= 0;
    exover_int count = what < EXOVER_SECTIONS ? c->counts[what] : what == REALS ? reals : many[what - FLAG];
    exover_int least = how == OR_NONE(0) ? -1 : how == OR_ALWAYS(0) ? -2 : how == TO(0) ? word[-1] : 0;
    return *word >= least && *word < count + (how == FROM(0) || how == TO(0));
}

/* Find the sections, and whether every field of every record holds. */
static bool fields_hold(exover *c, const exover_tables *tables)
{
    const exover_word *word = tables->words;
    const uint8_t *schema = SCHEMA;
    for (int section = 0; section < EXOVER_SECTIONS; section++) {
        c->sections[section] = word;
        for (exover_int record = 0; record < c->counts[section]; record++)
            for (int field = 0; field < FIELDS[section]; field++, word++)
                if (!field_holds(c, word, (exover_int)tables->real_count, schema[field]))
                    return false;
        schema += FIELDS[section];
    }
    return true;
}

static uint32_t crc(uint32_t sum, uint64_t value, int bytes)
{
    static const uint32_t NIBBLES[16] = {
        0x00000000, 0x1db71064, 0x3b6e20c8, 0x26d930ac, 0x76dc4190, 0x6b6b51f4, 0x4db26158, 0x5005713c,
        0xedb88320, 0xf00f9344, 0xd6d6a3e8, 0xcb61b38c, 0x9b64c2b0, 0x86d3d2d4, 0xa00ae278, 0xbdbdf21c};
    for (int nibble = 0; nibble < 2 * bytes; nibble++) {
        sum = NIBBLES[(sum ^ (uint32_t)value) & 15] ^ (sum >> 4);
        value >>= 4;
    }
    return sum;
}

/* CRC-32 (the one of Ethernet) of the bytes of the tables in their canonical form, the checksum itself taken as 0. */
static uint32_t checksum(const exover_tables *tables)
{
    uint32_t sum = 0xffffffffu;
    for (size_t i = 0; i < EXOVER_HEAD_WORDS; i++)
        sum = crc(sum, i == EXOVER_HEAD_CHECKSUM ? 0 : tables->head[i], 4);
    for (size_t i = 0; i < tables->real_count; i++)
        sum = crc(sum, tables->reals[i].bits, 8);
    for (size_t i = 0; i < tables->word_count; i++)
        sum = crc(sum, (uint64_t)tables->words[i], EXOVER_WIDTH);
    return ~sum;
}

/* Take the numbers of records from the header; false if they do not give the sizes of the arrays. */
static bool counts_fit(exover *c, const exover_tables *tables)
{
    size_t left = tables->word_count;
    for (int section = 0; section < EXOVER_SECTIONS; section++) {
        uint32_t count = tables->head[EXOVER_HEAD_COUNTS + section];
        if (count > left / FIELDS[section] || count > INT32_MAX / 32)
            return false;
        c->counts[section] = (int32_t)count;
        left -= (size_t)count * FIELDS[section];
    }
    return left == 0 && tables->head[EXOVER_HEAD_REALS] == tables->real_count && tables->real_count <= INT32_MAX / 32;
}

/* Every child after its parent, so that every walk ends; every action one that there is, with a target that there is. */
static bool nodes_hold(const exover *c, exover_int slots)
{
    for (exover_int i = 0; i < c->counts[NODES]; i++) {
        const exover_node *node = RECORD(node, NODES, i);
        exover_int high = node->high, least = 0, end = c->counts[REQUESTS];
        if (node->low != NONE && node->low <= i)
            return false;
        if (node->code >= 0) {
            if (node->code >= c->counts[ENTRIES] || high < NONE || high >= c->counts[NODES] || (high >= 0 && high <= i))
                return false;
            continue;
        }
        if (node->code == -KILL)
            least = -slots;
        else if (node->code != -DISMISS)
            end = high + 1; /* no target */
        if (node->code < -AGREE || node->bound < 0 || high < least || high >= end)
            return false;
    }
    return true;
}

static bool sums_hold(const exover *c)
{
    for (exover_int i = 0; USES(SUMS) && i < c->counts[SUMS]; i++) {
        const exover_entry *sum = RECORD(entry, ENTRIES, RECORD(sum, SUMS, i)->entry);
        if (sum->sums != sum->sums_end)
            return false;
    }
    return true;
}

/* Whether the words `from .. to` of the lists are indices of records of a section. */
static bool list_holds(const exover *c, exover_int from, exover_int to, int section)
{
    for (; from < to; from++)
        if (!below(LIST[from], c->counts[section]))
            return false;
    return true;
}

/* Whether both sides of every comparison are there: one of so many parameters, or a poster whose value is kept. */
static bool orders_hold(const exover *c, exover_int from, exover_int to, exover_int params)
{
    for (; USES(ORDERS) && from < to; from++) {
        const exover_order *order = RECORD(order, ORDERS, from);
        for (int side = 0; side < 2; side++) {
            exover_int k = side ? order->right : order->left;
            if (k >= params || -1 - k >= c->counts[VARIABLES]
                || (k < 0 && RECORD(variable, VARIABLES, -1 - k)->raw < 0))
                return false;
        }
    }
    return true;
}

static bool requests_hold(const exover *c, exover_int *slots)
{
    *slots = 0;
    for (exover_int i = 0; i < c->counts[REQUESTS]; i++) {
        const exover_request *row = REQUEST(i);
        if (row->slots != *slots || row->instances < 1 || row->instances > MOST_SLOTS - *slots
            || !orders_hold(c, row->orders, row->orders_end, row->params_end - row->params))
            return false;
        for (exover_int k = row->features; k < row->features_end; k++) {
            const exover_feature *feature = RECORD(feature, FEATURES, k);
            if (feature->slot < NONE || feature->slot >= row->instances || feature->weight >= row->results - row->params)
                return false;
        }
        *slots += row->instances;
    }
    return true;
}

/* Whether the records that refer to lists or to variables of some type do so rightly. */
static bool records_hold(const exover *c, exover_int reals)
{
    for (exover_int i = 0; i < c->counts[ENTRIES]; i++)
        if (!list_holds(c, RECORD(entry, ENTRIES, i)->rules, RECORD(entry, ENTRIES, i)->rules_end, RULES))
            return false;
    for (exover_int i = 0; USES(VARIABLES) && i < c->counts[VARIABLES]; i++) {
        const exover_variable *row = RECORD(variable, VARIABLES, i);
        if (!list_holds(c, row->refresh, row->refresh_end, REQUESTS)
            || !orders_hold(c, row->orders, row->orders_end, 0) || (row->raw >= 0 && row->domain.type != REAL)
            || (row->role != POSTER && row->domain.type == REAL))
            return false;
    }
    for (exover_int i = 0; USES(LATCHES) && i < c->counts[LATCHES]; i++) {
        const exover_latch *row = RECORD(latch, LATCHES, i);
        if (!list_holds(c, row->resets, row->resets_end, REQUESTS)
            || RECORD(variable, VARIABLES, row->variable)->role == POSTER)
            return false;
    }
    for (exover_int i = 0; USES(EFFECTS) && i < c->counts[EFFECTS]; i++) {
        const exover_effect *row = RECORD(effect, EFFECTS, i);
        if (row->target >= c->counts[row->kind == SET ? VARIABLES : REQUESTS]
            || (row->kind == SET && RECORD(variable, VARIABLES, row->target)->role == POSTER))
            return false;
    }
    for (exover_int i = 0; USES(LAUNCHES) && i < c->counts[LAUNCHES]; i++) {
        const exover_launch_rule *row = RECORD(launch_rule, LAUNCHES, i);
        const exover_request *request = REQUEST(row->request);
        exover_int params = request->results - request->params;
        if (row->args > c->counts[LISTS] - params)
            return false;
        for (exover_int k = 0; k < params; k++)
            if (RECORD(param, PARAMS, request->params + k)->domain.type == REAL && !below(LIST[row->args + k], reals))
                return false;
    }
    return true;
}

/* Volatile, since compilers make a call of the C library of a plain loop. */
static void wipe(volatile unsigned char *bytes, size_t size)
{
    while (size-- > 0)
        *bytes++ = 0;
}

typedef struct arena {
    unsigned char *at;
    size_t left;
} arena;

/* Hand out the next of the memory, wiped, a multiple of 8 bytes; NULL from the first array on that does not fit. */
static void *take(arena *memory, size_t count, size_t size)
{
    unsigned char *array = memory->at;
    if (array == NULL || count > memory->left / size || (count * size + 7) / 8 * 8 > memory->left) {
        memory->at = NULL;
        return NULL;
    }
    size = (count * size + 7) / 8 * 8;
    wipe(array, size);
    memory->at += size;
    memory->left -= size;
    return array;
}

static size_t bits(exover_int count)
{
    return ((size_t)count + 31) / 32;
}

/* Lay out the state in the memory; false if it does not fit. docs/runtime.md gives the same sum. */
static bool lay_out(exover *c, arena memory, exover_int slots)
{
    size_t requests = (size_t)c->counts[REQUESTS], launches = (size_t)c->counts[LAUNCHES];
    size_t values = 0, most = 0, raws = 0, limit = memory.left / sizeof(exover_value);
    limit = limit < INT32_MAX ? limit : INT32_MAX;
    c->args = take(&memory, requests, sizeof *c->args);
    if (c->args == NULL)
        return false;
    for (size_t i = 0; i < requests; i++) {
        size_t params = (size_t)(REQUEST(i)->results - REQUEST(i)->params);
        c->args[i] = (uint32_t)values;
        if (params != 0 && (size_t)REQUEST(i)->instances + 1 > (limit - values) / params)
            return false;
        values += params * ((size_t)REQUEST(i)->instances + 1);
        most = params > most ? params : most;
    }
    for (exover_int i = 0; i < c->counts[VARIABLES]; i++) {
        exover_int raw = RECORD(variable, VARIABLES, i)->raw;
        raws = raw >= 0 && (size_t)raw >= raws ? (size_t)raw + 1 : raws;
    }
    const exover_limits *limits = RECORD(limits, LIMITS, 0);
    c->capacity = 2 * slots + c->counts[REQUESTS] + 3 * c->counts[LAUNCHES] + (exover_int)limits->violations + 4;
    c->values = take(&memory, values, sizeof *c->values);
    c->scratch = take(&memory, launches == 0 ? 0 : most, sizeof *c->scratch);
    c->raw = take(&memory, raws, sizeof *c->raw);
    c->vector = take(&memory, (size_t)c->counts[ENTRIES], sizeof *c->vector);
    c->actions = take(&memory, (size_t)c->capacity + 1, sizeof *c->actions); /* one more for a fault */
    c->path = take(&memory, (size_t)limits->actions, sizeof *c->path);
    c->dirty = take(&memory, bits(c->counts[RULES]), sizeof *c->dirty);
    c->broken = take(&memory, bits(c->counts[RULES]), sizeof *c->broken);
    c->taken = take(&memory, bits(c->counts[REQUESTS]), sizeof *c->taken);
    c->marks = take(&memory, bits(c->counts[LAUNCHES] + c->counts[REQUESTS]), sizeof *c->marks);
    c->phases = take(&memory, (size_t)slots + requests, sizeof *c->phases);
    return memory.at != NULL;
}

/* Posters and states as they start, every rule to be looked at; the memory is wiped, so everything else is idle. */
static void start(exover *c)
{
    for (exover_int i = 0; i < c->counts[ENTRIES]; i++)
        c->vector[i] = RECORD(entry, ENTRIES, i)->initial;
    for (exover_int i = 0; USES(VARIABLES) && i < c->counts[VARIABLES]; i++) {
        const exover_variable *row = RECORD(variable, VARIABLES, i);
        if (row->raw >= 0)
            c->raw[row->raw] = c->reals[row->initial].real;
    }
    for (exover_int i = 0; i < c->counts[RULES]; i++)
        set_bit(c->dirty, i);
    c->attention = (c->counts[RULES] ? DIRTY : 0u) | (c->counts[LAUNCHES] ? REQUIRED : 0u);
}

static exover_status check(exover *c, const exover_tables *tables, unsigned char *memory, size_t size)
{
    exover_int slots;
    if (tables == NULL || memory == NULL || (tables->words == NULL && tables->word_count != 0)
        || (tables->reals == NULL && tables->real_count != 0))
        return EXOVER_NO_TABLES;
    if ((uintptr_t)memory % 8 != 0)
        return EXOVER_MISALIGNED;
    if (tables->head[EXOVER_HEAD_MAGIC] != 0x564f5845) /* "EXOV" */
        return EXOVER_NO_MAGIC;
    if ((tables->head[EXOVER_HEAD_FORMAT] & 0xffff) != 2)
        return EXOVER_OTHER_FORMAT;
    if (tables->head[EXOVER_HEAD_FORMAT] >> 16 != EXOVER_WIDTH)
        return EXOVER_OTHER_WIDTH;
    if (!counts_fit(c, tables))
        return EXOVER_BAD_COUNTS;
    for (int section = 0; section <= REALS; section++)
        if (!USES(section) && (section == REALS ? tables->real_count != 0 : c->counts[section] != 0))
            return EXOVER_OTHER_USES;
    if (checksum(tables) != tables->head[EXOVER_HEAD_CHECKSUM])
        return EXOVER_BAD_CHECKSUM;
    c->flags = tables->head[EXOVER_HEAD_FLAGS];
    c->reals = tables->reals;
    if (!fields_hold(c, tables) || !requests_hold(c, &slots) || !records_hold(c, (exover_int)tables->real_count))
        return EXOVER_BAD_INDEX;
    if (!nodes_hold(c, slots))
        return EXOVER_BAD_NODE;
    if (!sums_hold(c))
        return EXOVER_BAD_SUM;
    const exover_limits *limits = RECORD(limits, LIMITS, 0);
    if (c->counts[LIMITS] != 1 || limits->passes < 1 || limits->violations > c->counts[RULES]
        || limits->passes / 4 > slots + c->counts[REQUESTS] + c->counts[LAUNCHES])
        return EXOVER_BAD_LIMITS;
    arena all = {memory, size};
    return lay_out(c, all, slots) ? EXOVER_READY : EXOVER_NO_MEMORY;
}

exover_status exover_load(exover *c, const exover_tables *tables, void *memory, size_t size)
{
    if (c == NULL)
        return EXOVER_NO_TABLES;
    wipe((volatile unsigned char *)c, sizeof *c);
    exover_status found = check(c, tables, memory, size);
    if (found == EXOVER_READY) {
        start(c);
    } else {
        wipe((volatile unsigned char *)c, sizeof *c);
        c->fault = found;
    }
    return found;
}
