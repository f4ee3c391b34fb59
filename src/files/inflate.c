/* inflate.c: unpacks what a zip file holds (RFC 1951, numbers of its sections in parentheses). */
#include <string.h>

#include "files/formats.h"

enum { longest_code = 15, literals = 288, distances = 30, end_of_block = 256 };

typedef struct unpacking {
  dlsi_bytes in;
  size_t at; /* next byte of in */
  unsigned bits;
  int count; /* of bits */
  unsigned char *out;
  size_t room, used;
  int broken;
} unpacking;

/* A Huffman code (3.2.2): codes of one length are consecutive. symbol: by length, then value. */
typedef struct huffman {
  int first[longest_code + 1], count[longest_code + 1], start[longest_code + 1];
  short symbol[literals];
} huffman;

/* Takes the next n <= 16 bits, the lowest first (3.1.1); 0 past the end. */
static unsigned take_bits(unpacking *u, int n) {
  while (u->count < n) {
    if (u->at == u->in.size) {
      u->broken = 1;
      return 0;
    }
    u->bits |= (unsigned)u->in.at[u->at++] << u->count;
    u->count += 8;
  }
  const unsigned value = u->bits & ((1u << n) - 1);
  u->bits >>= n;
  u->count -= n;
  return value;
}

/* Makes the code of the lengths of n symbols; returns 0 if more codes are used than there are. */
static int huffman_make(huffman *code, const unsigned char *length, int n) {
  *code = (huffman){0};
  for (int k = 0; k < n; k++)
    code->count[length[k]] += length[k] > 0;
  for (int bits = 1; bits <= longest_code; bits++) {
    code->first[bits] = 2 * (code->first[bits - 1] + code->count[bits - 1]);
    code->start[bits] = code->start[bits - 1] + code->count[bits - 1];
    if (code->first[bits] + code->count[bits] > 1 << bits) return 0;
  }
  int next[longest_code + 1];
  memcpy(next, code->start, sizeof next);
  for (int k = 0; k < n; k++)
    if (length[k]) code->symbol[next[length[k]]++] = (short)k;
  return 1;
}

static int huffman_take(unpacking *u, const huffman *code) {
  int value = 0;
  for (int bits = 1; bits <= longest_code && !u->broken; bits++) {
    value = 2 * value + (int)take_bits(u, 1);
    const int place = value - code->first[bits];
    if (place < code->count[bits]) return code->symbol[code->start[bits] + place];
  }
  u->broken = 1;
  return end_of_block;
}

/* Copies a block that is not packed (3.2.4). */
static void copy_block(unpacking *u) {
  u->bits = 0;
  u->count = 0;
  const unsigned length = take_bits(u, 16), complement = take_bits(u, 16);
  u->broken |=
      (length ^ complement) != 0xffff || length > u->in.size - u->at || length > u->room - u->used;
  if (u->broken) return;
  memcpy(u->out + u->used, u->in.at + u->at, length);
  u->at += length;
  u->used += length;
}

/* Returns value k of a table of extra bits (3.2.5): `group` values have the same number of them. */
static size_t take_extra(unpacking *u, int k, int group, size_t least) {
  if (k < 2 * group) return least + (size_t)k;
  const int extra = k / group - 1;
  return least + ((size_t)(group + k % group) << extra) + take_bits(u, extra);
}

static void unpack_block(unpacking *u, const huffman *literal, const huffman *distance) {
  for (int symbol; !u->broken && (symbol = huffman_take(u, literal)) != end_of_block;) {
    if (symbol < end_of_block) {
      if (u->used == u->room)
        u->broken = 1;
      else
        u->out[u->used++] = (unsigned char)symbol;
      continue;
    }
    const size_t length = symbol == 285 ? 258 : take_extra(u, symbol - 257, 4, 3);
    const int code = huffman_take(u, distance);
    const size_t back = code < distances ? take_extra(u, code, 2, 1) : 0;
    u->broken |= symbol > 285 || !back || back > u->used || length > u->room - u->used;
    for (size_t k = 0; !u->broken && k < length; k++, u->used++)
      u->out[u->used] = u->out[u->used - back];
  }
}

/* Reads the lengths of both codes (3.2.7), or sets those of 3.2.6. */
static void read_codes(unpacking *u, int fixed, huffman *literal, huffman *distance) {
  static const unsigned char order[] = {16, 17, 18, 0, 8,  7, 9,  6, 10, 5,
                                        11, 4,  12, 3, 13, 2, 14, 1, 15};
  unsigned char length[literals + 32] = {0}, lengths[19] = {0};
  int literal_count = literals, distance_count = distances;
  if (fixed) {
    memset(length, 8, 144);
    memset(length + 144, 9, 112);
    memset(length + 256, 7, 24);
    memset(length + 280, 8, 8);
    memset(length + literals, 5, distances);
  } else {
    literal_count = 257 + (int)take_bits(u, 5);
    distance_count = 1 + (int)take_bits(u, 5);
    const int count = 4 + (int)take_bits(u, 4), all = literal_count + distance_count;
    for (int k = 0; k < count; k++)
      lengths[order[k]] = (unsigned char)take_bits(u, 3);
    u->broken |= literal_count > 286 || !huffman_make(literal, lengths, 19);
    for (int k = 0; k < all && !u->broken;) {
      const int symbol = huffman_take(u, literal);
      const unsigned char value = symbol < 16         ? (unsigned char)symbol
                                  : symbol == 16 && k ? length[k - 1]
                                                      : 0;
      int repeat = symbol < 16    ? 1
                   : symbol == 16 ? 3 + (int)take_bits(u, 2)
                   : symbol == 17 ? 3 + (int)take_bits(u, 3)
                                  : 11 + (int)take_bits(u, 7);
      u->broken |= repeat > all - k || (symbol == 16 && !k);
      while (!u->broken && repeat-- > 0)
        length[k++] = value;
    }
  }
  u->broken = u->broken || !huffman_make(literal, length, literal_count) ||
              !huffman_make(distance, length + literal_count, distance_count);
}

int dlsi_inflate(const dlsi_bytes *from, unsigned char *to, size_t size) {
  unpacking u = {.in = *from, .out = to, .room = size};
  huffman literal, distance;
  for (int last = 0; !last && !u.broken;) {
    last = (int)take_bits(&u, 1);
    const unsigned kind = take_bits(&u, 2);
    u.broken |= kind == 3;
    if (u.broken) break;
    if (kind == 0) {
      copy_block(&u);
      continue;
    }
    read_codes(&u, kind == 1, &literal, &distance);
    if (!u.broken) unpack_block(&u, &literal, &distance);
  }
  return !u.broken && u.used == size;
}
