/* Files that are exchanged while the component runs: see double.h. */
#include "double.h"

#include <stdio.h>
#include <stdlib.h>
#include <sys/stat.h>
#include <unistd.h>

#define MOST (2 << 20)

static size_t get(const char *path, uint8_t *to)
{
    FILE *stream = fopen(path, "rb");
    size_t length = stream ? fread(to, 1, MOST, stream) : 0;
    if (stream)
        fclose(stream);
    return length;
}

static void put(const char *path, const uint8_t *bytes, size_t length)
{
    FILE *stream = fopen(path, "wb");
    if (!stream || fwrite(bytes, 1, length, stream) != length || fclose(stream) != 0) {
        perror(path);
        exit(1);
    }
}

void files_change(const char *path, char **whole, int count, struct motion *motion)
{
    static uint8_t bytes[MOST];
    if (remove(path) != 0 && access(path, F_OK) == 0) {
        perror(path);
        exit(1);
    }
    /* First every file once and whole, so that some are accepted and some refused; then random changes. */
    static int changes;
    bool first = changes++ < count;
    uint64_t what = first ? 0 : inputs_random(motion) % 12;
    size_t length = get(whole[first ? (uint64_t)(changes - 1) : inputs_random(motion) % (uint64_t)count], bytes);
    if (what < 6)
        put(path, bytes, length);
    else if (what == 6 && length > 0) {
        bytes[inputs_random(motion) % length] ^= (uint8_t)(1u << inputs_random(motion) % 8);
        put(path, bytes, length);
    } else if (what == 7)
        put(path, bytes, length > 0 ? (size_t)(inputs_random(motion) % length) : 0);
    else if (what == 8)
        put(path, bytes, MOST); /* longer than any file */
    else if ((what == 9 && mkdir(path, 0700) != 0) || (what == 10 && mkfifo(path, 0600) != 0)) {
        perror(path);
        exit(1);
    } /* 11: no file */
}
