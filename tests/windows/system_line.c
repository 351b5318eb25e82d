/* system_line FILE: gives the first line of a file, in UTF-8, to `cmd /c`, as MATLAB's system() and dos() do, and ends with its exit
   code. For tests only: from outside of Wine no quotes can be put into a command line. */
#include <process.h>
#include <stdio.h>
#include <stdlib.h>
#include <wchar.h>
#include <windows.h>

int wmain(int count, wchar_t **words)
{
    char bytes[4096] = "";
    wchar_t line[4096] = L"";
    FILE *file = count > 1 ? _wfopen(words[1], L"rb") : NULL;

    if (file == NULL || fgets(bytes, sizeof bytes, file) == NULL)
        return 200;
    MultiByteToWideChar(CP_UTF8, 0, bytes, -1, line, 4096);
    line[wcscspn(line, L"\r\n")] = 0;
    return _wsystem(line);
}
