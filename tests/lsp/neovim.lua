-- Run by Neovim without a window: its built-in client talks to the server, and what the buffer then holds is printed as JSON.
local file = vim.env.DECK
local seen = {}

local function wait(what, condition)
  seen[what] = vim.wait(20000, condition, 20)
end
-- The settings of the guide start the server once a deck is open; a command file of its folder shares it.
local running = vim.lsp.get_clients or vim.lsp.get_active_clients
vim.cmd("edit " .. vim.fn.fnamemodify(file, ":h") .. "/run.ACF")
vim.cmd("edit " .. file)
wait("started", function()
  return #running() == 1 and running()[1].initialized
end)
local client = running()[1].id
seen.attached = vim.lsp.buf_is_attached(vim.fn.bufnr("run.ACF"), client) and vim.lsp.buf_is_attached(0, client)

local function diagnostics()
  return vim.tbl_map(function(found) return found.code or found.user_data.lsp.code end, vim.diagnostic.get(0))
end
local function ask(method, params)
  local answers = vim.lsp.buf_request_sync(0, method, params, 20000)
  return answers and answers[client] and answers[client].result
end
local function text()
  return table.concat(vim.api.nvim_buf_get_lines(0, 0, -1, false), "\n")
end
local encoding = vim.lsp.get_client_by_id(client).offset_encoding

-- A key: the marker of a joint is one that is not there.
local line = vim.fn.search("^JOINT") - 1
local column = #vim.api.nvim_buf_get_lines(0, line, line + 1, false)[1]
vim.api.nvim_buf_set_text(0, line, column, line, column, { "9" })
wait("complained", function() return vim.tbl_contains(diagnostics(), "undefined-id") end)
seen.codes = diagnostics()
seen.place = { vim.diagnostic.get(0)[1].lnum, vim.diagnostic.get(0)[1].col }
vim.api.nvim_buf_set_text(0, line, column, line, column + 1, { "" })
wait("mended", function() return #vim.diagnostic.get(0) == 0 end)

-- Hover, rename, layout and completion, applied by the client itself.
vim.fn.cursor(vim.fn.search("^MARKER/20"), 9)
local here = vim.lsp.util.make_position_params(0, encoding)
seen.hover = ask("textDocument/hover", here).contents.value
here.newName = "25"
vim.lsp.util.apply_workspace_edit(ask("textDocument/rename", here), encoding)
seen.renamed = text()
local all = { textDocument = { uri = vim.uri_from_bufnr(0) }, options = { tabSize = 4, insertSpaces = true } }
vim.lsp.util.apply_text_edits(ask("textDocument/formatting", all), 0, encoding)
seen.laid = text()
vim.api.nvim_buf_set_lines(0, -2, -2, false, { "MARKER/30, PART = " })
vim.fn.cursor(vim.fn.line("$") - 1, 99)
vim.cmd("startinsert!")
local place = vim.lsp.util.make_position_params(0, encoding)
place.position.character = #"MARKER/30, PART = "
seen.items = vim.tbl_map(function(item) return item.label end, ask("textDocument/completion", place).items)
seen.symbols = #ask("textDocument/documentSymbol", all)

vim.lsp.stop_client(client)
seen.stopped = vim.wait(5000, function() return vim.lsp.get_client_by_id(client) == nil end, 20)
io.stdout:write(vim.json and vim.json.encode(seen) or vim.fn.json_encode(seen))
vim.cmd("qall!")
