/* Stands in for bcryptprimitives.dll, which Wine before 9 lacks; Rust's standard library takes its random numbers from there.
   SystemFunction036 of advapi32 is the same source under its older name, RtlGenRandom. For tests only. */
#include <windows.h>

BOOLEAN NTAPI SystemFunction036(PVOID buffer, ULONG length);

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T length)
{
    while (length > 0) {
        ULONG part = length > 0x10000 ? 0x10000 : (ULONG)length;
        if (!SystemFunction036(data, part))
            return FALSE;
        data += part;
        length -= part;
    }
    return TRUE;
}
