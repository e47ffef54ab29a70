/* What numba's machine code calls of numba's runtime, so that the library needs neither numba nor
 * Python. Only one thread uses an array that a function makes for itself, so nothing here locks.
 * The memory layout is that of numba/core/runtime/nrt.h. */

#include <stddef.h>
#include <stdint.h>
#include <stdlib.h>

typedef struct {
    size_t count;
    void (*destroy)(void *, size_t, void *);
    void *destroy_info;
    void *data;
    size_t size;
    void *allocator;
} MemInfo;

/* Returns memory for an array, NULL if there is none; `align` is in bytes. */
MemInfo *NRT_MemInfo_alloc_aligned(size_t size, unsigned align) {
    MemInfo *info = malloc(sizeof(MemInfo) + size + align);
    if (info == NULL)
        return NULL;
    uintptr_t first = (uintptr_t)(info + 1);
    *info = (MemInfo){.count = 1, .size = size};
    info->data = (void *)((first + align - 1) / align * align);
    return info;
}

/* Frees the memory of an array that nothing uses any more. */
void NRT_MemInfo_call_dtor(MemInfo *info) { free(info); }

/* Writes the strides of a reshaped array; returns 0 if the array is not contiguous in C order. */
int numba_attempt_nocopy_reshape(intptr_t dims, const intptr_t *shape, const intptr_t *strides,
                                 intptr_t new_dims, const intptr_t *new_shape,
                                 intptr_t *new_strides, intptr_t item_size, int fortran_order) {
    intptr_t step = item_size;
    if (fortran_order)
        return 0;
    for (intptr_t i = dims - 1; i >= 0; i--) {
        if (shape[i] != 1 && strides[i] != step)
            return 0;
        step *= shape[i];
    }
    step = item_size;
    for (intptr_t i = new_dims - 1; i >= 0; i--) {
        new_strides[i] = step;
        step *= new_shape[i];
    }
    return 1;
}
