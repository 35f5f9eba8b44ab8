// Help: the page is text; a link to a part that is further down shows it.
import { find } from './dom.js';

if (location.hash) find(location.hash)?.scrollIntoView();
