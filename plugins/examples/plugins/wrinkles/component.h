// What a plugin in C needs of the component model, and no more: the interface's records as C structs (their layout is the
// same), memory, and the host's functions. A plugin lives for one evaluation, so nothing is ever freed.
#pragma once
#include <stddef.h>
#include <stdint.h>

typedef struct { const char *text; uint32_t length; } string;
typedef struct { const void *data; uint32_t length; } list;
#define TEXT(literal) {literal, sizeof(literal) - 1}
#define LIST(array) {array, sizeof(array) / sizeof((array)[0])}

typedef struct { int64_t first; double rate_hz; uint32_t count; } frames;
typedef struct { frames time; list names, positions_m; } markers;
typedef struct { frames time; list channels, values; } curves;

enum value_kind { NUMBER, WORDS, TENSOR, MARKERS, CURVES, VIEWS, FEATURES, MESHES, IMAGE, BLOB };
typedef struct {
    uint8_t kind;
    union { double number; string words; markers markers; curves curves; uint64_t size[7]; };
} value;
typedef struct { string name; value value; } item;
typedef struct { string port; list items; } standing;

enum setting_kind { FLAG, INTEGER, REAL, NAME, REALS };
typedef struct {
    uint8_t kind;
    union { uint8_t flag; int64_t integer; double real; string name; list reals; };
} setting;
typedef struct { string name; setting value; } parameter;

typedef struct { uint8_t is; double number; } maybe;
typedef struct { string name, doc; setting otherwise; maybe least, most; list choices; } parameter_schema;
typedef struct { string name, type, doc; uint8_t optional, many, still; } port_schema;
enum time_kind { WHOLE, PER_FRAME, PER_FRAME_BY };
typedef struct { uint8_t kind; union { uint32_t halo; string parameter; }; } time_use;
typedef struct { string name, doc; uint32_t version; time_use time; list inputs, outputs, parameters; } node_schema;

enum fault_kind { WRONG_INPUT, WRONG_PARAMETER, FAILED, CANCELLED };
typedef struct { uint8_t kind; string name, problem; } fault;
typedef struct { uint8_t failed; union { list outputs; fault fault; }; } result;

_Static_assert(sizeof(frames) == 24 && sizeof(value) == 64 && sizeof(item) == 72, "values as the interface lays them out");
_Static_assert(sizeof(parameter_schema) == 72 && sizeof(port_schema) == 28 && sizeof(node_schema) == 56, "schemas too");
_Static_assert(sizeof(fault) == 20 && sizeof(result) == 24 && sizeof(parameter) == 24, "and what comes back");

#define EXPORT(name) __attribute__((export_name(name)))
#define HOST(name) __attribute__((import_module("grimace:node/host@0.1.0"), import_name(name)))

HOST("progress") int32_t host_progress(double fraction, const void *numbers, uint32_t count);

extern uint8_t __heap_base;
static uintptr_t heap_end = 0;

// Memory of `size` bytes at a multiple of `align`, which is a power of two.
static void *take(size_t size, size_t align) {
    if (heap_end == 0) heap_end = (uintptr_t)&__heap_base;
    uintptr_t start = (heap_end + align - 1) & ~(uintptr_t)(align - 1);
    heap_end = start + size;
    size_t have = __builtin_wasm_memory_size(0) << 16;
    if (heap_end > have && __builtin_wasm_memory_grow(0, (heap_end - have + 0xffff) >> 16) == (size_t)-1) __builtin_trap();
    return (void *)start;
}

EXPORT("cabi_realloc") void *cabi_realloc(void *old, size_t old_size, size_t align, size_t size) {
    uint8_t *fresh = take(size, align);
    for (size_t at = 0; at < old_size && at < size; at++) fresh[at] = ((uint8_t *)old)[at];
    return fresh;
}

static int same(string one, const char *other) {
    uint32_t at = 0;
    for (; at < one.length && other[at] != 0; at++) if (one.text[at] != other[at]) return 0;
    return at == one.length && other[at] == 0;
}

// The value on an input; null where nothing is connected.
static const value *input(const standing *inputs, uint32_t count, const char *port) {
    for (uint32_t at = 0; at < count; at++)
        if (same(inputs[at].port, port) && inputs[at].items.length > 0) return &((const item *)inputs[at].items.data)->value;
    return 0;
}

// The value of a parameter; the host gives every one that the schema has.
static setting given(const parameter *parameters, uint32_t count, const char *name) {
    for (uint32_t at = 0; at < count; at++)
        if (same(parameters[at].name, name)) return parameters[at].value;
    __builtin_trap();
}
