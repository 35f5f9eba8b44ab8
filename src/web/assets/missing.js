// Nothing is at this address: says so in words.
import { find } from './dom.js';

find('#address').textContent = location.pathname;
